"""The moves on a rig: `stillarm controller` runs them as its schedule, damping off, and is watched by its telemetry.

The controller is a process of its own, so that whatever becomes of this one, it lets the joint stand: SIGTERM, the end
of its parent, a bound exceeded or the operator's stop all end in the loop's own way to rest.
"""

import contextlib
import json
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from math import nan
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from stillarm.common.files.configuration import Configuration, load_configuration, model_path
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.common.process.child_process import start_module, stop_process
from stillarm.common.process.parent_death import ended_with_parent
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning.stop_listener import StopListener
from stillarm.diagnosis.commissioning.watch import Bounds, Watch, exceeded
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.reading import read_measured

_TELEMETRY_S = 0.02
_SILENT_S = 3.0  # without telemetry while the moves go on: nobody would see what they do
_START_S = 20.0
_STOP_S = 10.0
_METHOD = "timestamps"  # its estimate moves nothing here; it needs the least of the model


class LiveRig:
    """Records scenarios on the rig that a configuration names. The supervisor runs already, the controller does not.

    Between two of them the operator's stop is heard, too. To be closed.
    """

    def __init__(
        self,
        configuration_path: Path,
        model: Model,
        folder: Path,
        *,
        allow_non_realtime: bool,
        progress: Callable[[str, float, float], None] = lambda name, done_s, of_s: None,
    ) -> None:
        """Recordings, configurations and logs go to `folder`. progress: told the name of the
        part that is under way, how long it has been and how long it is to be, s.
        """
        self._path, self._model, self._folder = configuration_path, model, folder
        self._configuration = load_configuration(configuration_path.resolve())
        self._words = ("--allow-non-realtime",) if allow_non_realtime else ()
        self._progress = progress
        self._between: StopListener | None = None

    def rest(self, seconds: float) -> None:
        """Let the arm ring down for so long, or until the operator's stop."""
        if self._between is None:
            time.sleep(seconds)
        else:
            self._between.rest(seconds)

    def close(self) -> None:
        """Leave the operator's port. May be called twice."""
        if self._between is not None:
            self._between.close()
            self._between = None

    def record(self, name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        """Run a scenario as far as the bounds allow.

        Raises UserError when the controller fails or is stopped, or this computer is too busy to watch the moves.
        """
        self._refuse_after_stop()
        folder = self._folder.resolve()
        listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with contextlib.closing(listener):
            listener.bind(("127.0.0.1", 0))
            listener.settimeout(0.1)
            scenario_path = folder / f"{name}.scenario.toml"
            scenario_path.write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
            configuration = commissioning_configuration(
                self._configuration, self._path, scenario_path, listener.getsockname()[1]
            )
            path = folder / f"{name}.config.toml"
            path.write_text(tomli_w.dumps(msgspec.to_builtins(configuration)))
            recording, log = folder / f"{name}.mcap", folder / f"{name}.log"
            words = [
                "--config",
                str(path),
                "--record",
                str(recording),
                "--duration-s",
                str(scenario.duration_s),
            ]
            watch = Watch(bounds)
            with _controller([*words, *self._words], log) as process:
                self._watch(process, listener, scenario, watch, name, log)
        self._between = StopListener(self._configuration.link)
        if process.returncode != 0:
            raise UserError(f"commission: the controller failed: {_last_words(log)} (see {log})")
        recorded = open_recording(recording)
        _refuse_fault(recorded.columns("/estimate"))
        measured = read_measured(recorded, self._model)
        _refuse_blind_watch(watch, measured, bounds)
        return measured

    def _refuse_after_stop(self) -> None:
        """Raise UserError where the operator has asked for a stop since the last controller ended."""
        listener = self._between
        self.close()
        if listener is not None and listener.stopped:
            raise UserError(
                "commission: emergency stop, between two parts; the joint stands. See to it, and begin again"
            )

    def _watch(
        self,
        process: subprocess.Popen[bytes],
        listener: socket.socket,
        scenario: Scenario,
        watch: Watch,
        name: str,
        log: Path,
    ) -> None:
        """Until the controller has ended: by itself, or because of what the watch sees."""
        heard, started = time.monotonic() + _START_S, False
        decoder = msgspec.msgpack.Decoder(list[dict[str, Any]])
        while process.poll() is None:
            try:
                rows = decoder.decode(listener.recv(65536))
            except TimeoutError:
                if time.monotonic() > heard + (_SILENT_S if started else 0.0):
                    _stop(process)
                    raise UserError(
                        f"commission: the controller fell silent and was stopped; see {log}"
                    ) from None
                continue
            started, heard = True, time.monotonic()
            for row in rows:
                feed(watch, row)
            now = rows[-1].get("time_s", 0.0) if rows else 0.0
            self._progress(name, float(now), scenario.duration_s)
            if watch.exceeded is not None or _said_error(log):
                _stop(process)


def commissioning_configuration(
    configuration: Configuration, path: Path, scenario: Path, telemetry_port: int
) -> Configuration:
    """The user's configuration with the moves as its schedule and nothing that would add to them."""
    replace = msgspec.structs.replace
    controller = configuration.controller
    return replace(
        configuration,
        model=str(model_path(configuration, path).resolve()),
        controller=replace(
            controller,
            method=_METHOD,
            arm_at_start=True,
            schedule=str(scenario),
            reference_shaping="none",
            damping=replace(controller.damping, without_schedule=False),
            dither=replace(controller.dither, enabled=False),
            safety=replace(controller.safety, checks_before_arming=()),
        ),
        telemetry=replace(
            configuration.telemetry,
            enabled=True,
            host="127.0.0.1",
            port=telemetry_port,
            period_s=_TELEMETRY_S,
            every_cycles=1,
        ),
    )


def feed(watch: Watch, row: dict[str, Any]) -> None:
    """One of telemetry's maps to the watch."""
    time_s = row.get("time_s", nan)
    if (fast := row.get("fast")) is not None:
        watch.cycle(time_s, fast["acceleration_m_s2"], fast["joint_position_rad"])
    if (frame := row.get("frames")) is not None and frame["displacement_px"] == frame["displacement_px"]:
        watch.image(time_s, frame["displacement_px"])


@contextlib.contextmanager
def _controller(words: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The process; told to stop, and waited for, on every way out."""
    with log.open("wb") as said:
        process = start_module(
            "stillarm",
            "controller",
            *words,
            stdout=said,
            stderr=subprocess.STDOUT,
            preexec_fn=ended_with_parent(),  # no thread runs yet, and it calls the kernel only
        )
    try:
        yield process
    finally:
        _stop(process)


def _stop(process: subprocess.Popen[bytes]) -> None:
    """Ask it to come to rest and end; where it does not, end it: the drive's own dead man then stops the joint."""
    stop_process(process, _STOP_S)


def _refuse_fault(estimates: dict[str, Any]) -> None:
    """Raise UserError where the controller went into a fault: somebody or something stopped it."""
    for state, reason in zip(estimates["state"], estimates["reason"], strict=True):
        if state == "fault":
            raise UserError(
                f"commission: stopped by the controller: {reason}; the joint stands. See to it, and begin again"
            )


def _refuse_blind_watch(watch: Watch, measured: Measured, bounds: Bounds) -> None:
    """Raise UserError where the watch ended the moves for what the recording does not show: telemetry was lost."""
    if watch.exceeded is not None and exceeded(measured, bounds) is None:
        raise UserError(
            f"commission: {watch.exceeded} in the telemetry by which the moves are watched, though the recording "
            f"({measured.name}) does not show it: this computer is too busy; end what else runs on it, and begin again"
        )


def _said_error(log: Path) -> bool:
    """Whether the controller has said something grave, such as a fault. Its log is a few lines long."""
    return b'"level":"error"' in log.read_bytes()


def _last_words(log: Path) -> str:
    lines = log.read_text(errors="replace").strip().splitlines()
    if not lines:
        return "it said nothing"
    with contextlib.suppress(ValueError, KeyError, TypeError):
        return str(json.loads(lines[-1])["event"])
    return lines[-1].removeprefix("stillarm: ")
