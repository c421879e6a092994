"""Rig, supervisor and controller in real time; the supervisor is killed in mid-swing and another takes its place."""

import contextlib
import subprocess
import time
from pathlib import Path

import msgspec
import tomli_w

from stillarm.benchmarks.live.beside import Floor, company
from stillarm.benchmarks.live.kills.kill_plan import Kill
from stillarm.benchmarks.loop.counters import block_name
from stillarm.common.files.scenario import Scenario
from stillarm.common.process.child_process import next_line, start_module, stop_process
from stillarm.common.process.loop_processor import beside_the_loop
from stillarm.common.process.parent_death import ended_with_parent
from stillarm.common.user_error import UserError
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.simulation.demo.demo import Progress, compile_ahead, remove_shared_memory, wait_for_camera
from stillarm.simulation.demo.processes import DemoProcesses
from stillarm.simulation.demo.set_up import write_demo_configuration

CYCLE_S = 0.001  # of the demo's model
_STOP_WITHIN_S = 15.0
_READY_WITHIN_S = 60.0
"""Longer than the controller itself waits for its devices and its own processes, and then tells which is missing."""
_OVER_TIME_S = 30.0
_POLL_S = 0.05
_TO_FIRST_IMAGE_S = 0.2
"""From the word to a waiting supervisor until the controller reads its first image."""
_SPARE_BEFORE_KILL_S = 2.0
"""So long before a kill its successor starts loading; it has the processors that the loop does not take."""


def run_kills(
    directory: Path, kills: list[Kill], scenario: Scenario, seed: int, load: int, progress: Progress
) -> None:
    """Leave recording.mcap and truth.mcap in `directory`. Raises UserError when a process fails; none runs on."""
    path, configuration, _ = write_demo_configuration(directory, scenario.duration_s, seed)
    (directory / "scenario.toml").write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
    compile_ahead(path, configuration)
    processes = DemoProcesses(directory)
    try:
        processes.start("rig", "--config", str(path), "--truth", str(directory / "truth.mcap"))
        with Supervisors(path, directory / "supervisor.log") as supervisors:
            supervisors.prepare()
            supervisors.begin()
            wait_for_camera(configuration.camera.device, processes)
            processes.start(
                "controller",
                *("--config", str(path), "--record", str(directory / "recording.mcap")),
                *("--duration-s", str(scenario.duration_s), "--allow-non-realtime"),
            )
            _kill_and_wait(processes, supervisors, kills, scenario.duration_s, load, progress)
    finally:
        processes.stop_all()
        remove_shared_memory(configuration)


def _kill_and_wait(
    processes: DemoProcesses,
    supervisors: "Supervisors",
    kills: list[Kill],
    duration_s: float,
    load: int,
    progress: Progress,
) -> None:
    """Kill and replace the supervisor as planned, and wait for the controller's end."""
    controller = processes.process_id("controller")
    with company(controller, CYCLE_S, load, Floor()), beside_the_loop(), progress("kills") as done:
        origin_s = _origin_s(controller, processes)

        def wait_until(at_s: float) -> None:
            while (left_s := origin_s + at_s - time.monotonic()) > 0.0:
                processes.check()
                supervisors.check()
                done((at_s - left_s) / duration_s)
                time.sleep(min(left_s, _POLL_S))

        for kill in kills:
            wait_until(kill.at_s - _SPARE_BEFORE_KILL_S)
            supervisors.prepare()
            wait_until(kill.at_s)
            supervisors.kill()
            time.sleep(max(0.0, kill.gap_s - _TO_FIRST_IMAGE_S))
            supervisors.begin()
        wait_until(duration_s)
        processes.wait_for("controller", _OVER_TIME_S, lambda passed: None)


def _origin_s(controller: int, processes: DemoProcesses) -> float:
    """The controller's cycle 0 on the monotonic clock, once there is one. Raises UserError."""
    deadline = time.monotonic() + _READY_WITHIN_S
    while time.monotonic() < deadline:
        processes.check()
        name = block_name(controller)
        with contextlib.suppress(UserError):  # just being made
            if name is not None and (origin_s := LoopBlock(name, create=False).origin_s):
                return origin_s
        time.sleep(_POLL_S)
    raise UserError("the demo's controller did not begin in time; see controller.log in the output folder")


class Supervisors:
    """The supervisor that works, and the one that waits to take its place."""

    def __init__(self, configuration: Path, log: Path) -> None:
        """log: where they write what they say."""
        self._configuration = configuration
        self._log = log.open("wb")
        self._working: subprocess.Popen[bytes] | None = None
        self._waiting: subprocess.Popen[bytes] | None = None

    def prepare(self) -> None:
        """Start one that waits."""
        self._waiting = start_module(
            "stillarm.benchmarks.live.kills.spare",
            str(self._configuration),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            preexec_fn=ended_with_parent(),  # no thread runs yet, and it calls the kernel only
        )

    def begin(self) -> None:
        """Let the one that waits work. Raises UserError where it does not come to it."""
        assert self._waiting is not None and self._waiting.stdin is not None
        if next_line(self._waiting, _READY_WITHIN_S) != "ready":
            raise UserError(f"a supervisor did not load in time; see {self._log.name}")
        self._waiting.stdin.write(b"begin\n")
        self._waiting.stdin.flush()
        self._working, self._waiting = self._waiting, None

    def kill(self) -> None:
        """SIGKILL: it can save nothing, and say nothing."""
        assert self._working is not None
        self._working.kill()
        self._working.wait()
        self._working = None

    def check(self) -> None:
        """Raise UserError where the one that works has ended by itself."""
        if self._working is not None and (status := self._working.poll()) is not None:
            raise UserError(f"the supervisor ended (status {status}); see {self._log.name}")

    def __enter__(self) -> "Supervisors":
        return self

    def __exit__(self, *_: object) -> None:
        for process in (self._working, self._waiting):
            if process is not None:
                stop_process(process, _STOP_WITHIN_S)
        self._log.close()
