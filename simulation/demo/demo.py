"""The demonstration: a flexible arm rings in real time and is then stilled through a camera that is 74 ms late."""

import json
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from stillarm.common.files.configuration import Configuration, load_true_model, true_model_path
from stillarm.common.files.scenario import Scenario
from stillarm.common.memory.shared_memory import block_path
from stillarm.common.process.loop_processor import beside_the_loop
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.replay.replay import (
    LiveComparison,
    RecordedRun,
    compare_with_live,
    read_run,
    replay_method,
)
from stillarm.drivers.buses.i2c import MEMORY_PREFIX
from stillarm.drivers.buses.serial_port import port_path
from stillarm.simulation.arm.ahead import ready_plant
from stillarm.simulation.camera.camera_process import pose_history_name
from stillarm.simulation.demo.hidden_effect import SHORTEST_S as SHORTEST_HIDDEN_S
from stillarm.simulation.demo.own_folder import own_folder
from stillarm.simulation.demo.processes import DemoProcesses
from stillarm.simulation.demo.scoring import damping_scores, method_scores
from stillarm.simulation.demo.set_up import LONGEST_S, RIG_MODEL_NAME, SHORTEST_S, write_demo_configuration
from stillarm.simulation.demo.truth_file import read_truth
from stillarm.simulation.rig.strike_requests import strikes_name

METHODS = ("timestamps", "correlation", "fused")
_RIG_READY_WITHIN_S = 60.0  # where nothing can be kept on disk, the rig compiles its arm again
_OVER_TIME_S = 30.0

Progress = Callable[[str], AbstractContextManager[Callable[[float], None]]]
Beside = Callable[[int], AbstractContextManager[None]]
"""What goes on beside a run, given the number of the controller's process: entered when that has started."""


def _nothing_beside(controller: int) -> AbstractContextManager[None]:
    return nullcontext()


def run_demo(
    directory: Path,
    duration_s: float,
    seed: int,
    progress: Progress,
    accelerometer: str | None = None,
    *,
    drive: str | None = None,
    hide: int | None = None,
) -> dict[str, Any]:
    """Run it all into `directory`; returns what summary.json holds. Raises UserError when a process fails.

    accelerometer, drive: the devices that the rig emulates, by the driver's name; None: the configuration's. hide: seed
    of an effect that only the rig, and its truth file, know of.
    """
    if not SHORTEST_S <= duration_s <= LONGEST_S:
        raise UserError(
            f"--duration-s {duration_s:g}: at least {SHORTEST_S:g} s are needed for two strikes, "
            f"and at most {LONGEST_S:g} s fit the replay's memory"
        )
    if hide is not None and duration_s < SHORTEST_HIDDEN_S:
        raise UserError(
            f"--duration-s {duration_s:g}: at least {SHORTEST_HIDDEN_S:g} s are needed for the moves of --hide"
        )
    with own_folder(directory):
        return _run_and_score(directory, duration_s, seed, progress, accelerometer, drive, hide)


def _run_and_score(
    directory: Path,
    duration_s: float,
    seed: int,
    progress: Progress,
    accelerometer: str | None,
    drive: str | None,
    hide: int | None,
) -> dict[str, Any]:
    scenario = run_processes(directory, duration_s, seed, progress, accelerometer, drive, hide)
    recording = open_recording(directory / "recording.mcap")
    run = read_run(recording)
    truth = read_truth(directory / "truth.mcap", recording.header.origin_monotonic_s)
    if len(truth.strikes_s) < 2:
        raise UserError(
            "the demo's rig was struck less than twice; see rig.log and controller.log beside the recording"
        )
    replays = []
    for method in METHODS:
        with progress(f"replay, {method}") as done:
            replays.append(replay_method(run, method, done))
    with progress("replay, live method"):
        comparison = compare_with_live(run)
    scores = damping_scores(truth, run.model, scenario.damping[0].on_s)
    summary = summarise(
        recording, run, scores, {r.method: method_scores(r, truth, run.model) for r in replays}, comparison
    )
    (directory / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    with progress("figures"):
        from stillarm.simulation.demo.figures import draw_figures

        draw_figures(directory, run, truth, replays, summary)
    return summary


def run_processes(
    directory: Path,
    duration_s: float,
    seed: int,
    progress: Progress,
    accelerometer: str | None = None,
    drive: str | None = None,
    hide: int | None = None,
    beside: Beside = _nothing_beside,
) -> Scenario:
    """Rig, supervisor and controller in real time; leaves recording.mcap and truth.mcap in `directory`.

    Raises UserError when one of them fails; none runs on afterwards.
    """
    path, configuration, scenario = write_demo_configuration(
        directory, duration_s, seed, accelerometer, drive=drive, hide=hide
    )
    with progress("arm, compiled once"):
        compile_ahead(path, configuration)
    processes = DemoProcesses(directory)
    try:
        start_all(processes, path, configuration.camera.device, "--duration-s", str(duration_s))
        controller = processes.process_id("controller")
        # This process, too, keeps off the loop's processor; what goes on beside the run is not its own and may use it.
        with beside(controller), beside_the_loop(), progress("arm, camera, controller") as done:
            processes.wait_for(
                "controller", duration_s + _OVER_TIME_S, lambda passed: done(passed / duration_s)
            )
    finally:
        processes.stop_all()
        if hide is not None:  # the truth file holds it; nobody else is to
            (directory / RIG_MODEL_NAME).unlink(missing_ok=True)
        remove_shared_memory(configuration)
    return scenario


def compile_ahead(path: Path, configuration: Configuration) -> None:
    """Have the rig's arm compiled, and kept on disk, before any process that shares the computer with it starts."""
    ready_plant(load_true_model(configuration, path), str(true_model_path(configuration, path)))


def remove_shared_memory(configuration: Configuration) -> None:
    """Remove the shared memory of a killed rig; the names are this demo's own."""
    camera = configuration.camera.device
    for name in (
        configuration.accelerometer.bus.removeprefix(MEMORY_PREFIX),
        camera,
        pose_history_name(configuration),
        strikes_name(configuration),
    ):
        block_path(name).unlink(missing_ok=True)
    block_path(configuration.drive.mcp4725.bus.removeprefix(MEMORY_PREFIX)).unlink(missing_ok=True)
    for port in (configuration.accelerometer.port, configuration.drive.odrive.port):
        Path(port_path(port)).unlink(missing_ok=True)


def start_all(processes: DemoProcesses, path: Path, camera: str, *words: str) -> None:
    """Rig, supervisor and, once the camera is there, the controller, which record beside the configuration at `path`.

    words: further ones for the controller. Raises UserError where the camera does not come, or a process fails.
    """
    folder = path.parent
    processes.start("rig", "--config", str(path), "--truth", str(folder / "truth.mcap"))
    processes.start("supervisor", "--config", str(path))
    wait_for_camera(camera, processes)
    record = ("--config", str(path), "--record", str(folder / "recording.mcap"))
    processes.start("controller", *record, *words, "--allow-non-realtime")


def wait_for_camera(name: str, processes: DemoProcesses) -> None:
    """Wait until the rig shows its camera. Raises UserError where it does not in time, or a process fails."""
    deadline = time.monotonic() + _RIG_READY_WITHIN_S
    while not block_path(name).exists():
        processes.check()
        if time.monotonic() > deadline:
            raise UserError(
                "the demo's rig did not start its camera in time; see rig.log in the output folder"
            )
        time.sleep(0.05)


def summarise(
    recording: Recording,
    run: RecordedRun,
    damping: dict[str, float | None],
    methods: dict[str, dict[str, Any]],
    comparison: LiveComparison,
) -> dict[str, Any]:
    """The content of summary.json: the figures that outside scripts read, and the replay's verdict."""
    loop = recording.columns("/loop")
    link = recording.columns("/link")

    def percentiles(name: str) -> dict[str, float]:
        return {key: float(loop[f"{name}_{key}"][-1]) for key in ("p50", "p99", "p999", "max")}

    return {
        "cycles": int(loop["cycles"][-1]),
        "deadline_misses": int(loop["deadline_misses"][-1]),
        "wakeup_latency_us": percentiles("wakeup_latency_us"),
        "compute_us": percentiles("compute_us"),
        "frames": len(run.frames),
        "frames_lost": _frames_lost([frame.frame for frame in run.frames if frame.frame >= 0]),
        "datagrams_lost": int(link["lost"][-1]),
        "damping": damping,
        "methods": methods,
        "replay_identical": comparison.identical,
    }


def _frames_lost(counters: list[int]) -> int:
    return counters[-1] - counters[0] + 1 - len(counters) if counters else 0
