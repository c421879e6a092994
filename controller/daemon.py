"""The controller as a process: the loop around the step, with clock, devices and recorder at its edge."""

import gc
import time
from collections.abc import Callable
from pathlib import Path

from common.configuration import load_assumed_model, load_configuration, model_path
from common.effects import not_used_by_controller
from common.recording.header import live_header
from common.recording.recorder_client import RECORDING_CUT, RecorderClient
from common.recording.topics import TOPIC_INDEX, LinkSample, LoopSample
from common.service_notify import notify
from common.single_instance import hold_instance
from common.stop_signal import StopSignal
from common.structured_log import log, log_start
from common.user_error import UserError
from controller.histogram import MicrosecondHistogram
from controller.live_devices import LiveDevices
from controller.realtime import enter_realtime
from controller.recorded import estimate_sample, fast_sample, frame_sample
from controller.schedule import CycleClock
from controller.step import Controller, CycleInput, CycleOutput
from controller.warm_up import warm_up

_FADE_CYCLES = 100  # how long the loop runs on after it was asked to stop, fading the command
_LINK_EVERY_S = 1.0
_START_UP_S = 0.7  # until cycle 0: the recorder starts and memory is locked meanwhile


def run(
    configuration_path: Path, record: Path | None, duration_s: float | None, *, allow_non_realtime: bool
) -> None:
    """Run until SIGTERM or SIGINT, or for `duration_s`. Raises UserError for what the user can mend."""
    configuration = load_configuration(configuration_path)
    model = load_assumed_model(configuration, configuration_path)
    cycle_s = model.timing.cycle_s
    model_name = str(model_path(configuration, configuration_path))
    if unused := not_used_by_controller(model):
        log("controller", "warning", unused)
    controller = Controller(model, configuration.controller, model_name)
    hold_instance("controller", configuration.link.controller_port)
    devices = LiveDevices(configuration, cycle_s)
    stop = StopSignal()
    log_start("controller", configuration, configuration_path)
    devices.start()
    recorder: RecorderClient | None = None
    clock = CycleClock(cycle_s, time.monotonic() + _START_UP_S)
    try:
        header = live_header(configuration_path, configuration, devices.session, clock.origin_s)
        recorder = RecorderClient.start(
            record, header, telemetry=configuration.telemetry, process_name="controller"
        )
        _grant_realtime(allow_non_realtime)
        warm_up(model, configuration.controller, model_name)
        loop = _Loop(controller, devices, recorder, clock, cycle_s)
        last = None if duration_s is None else int(duration_s / cycle_s)
        notify("READY=1")
        loop.run(lambda cycle: bool(stop) or (last is not None and cycle >= last))
        notify("STOPPING=1")
        print(loop.summary(), flush=True)
    finally:
        devices.close()
        gc.enable()
        if recorder is not None and not recorder.close():
            log("controller", "error", RECORDING_CUT, recording=str(record), lost=recorder.lost)


def _grant_realtime(allow_non_realtime: bool) -> None:
    problems = enter_realtime()
    if not problems:
        return
    if not allow_non_realtime:
        raise UserError(
            f"controller: no real-time operation: {'; '.join(problems)}; or start with --allow-non-realtime"
        )
    log("controller", "warning", "not real-time", missing=problems)


class _Loop:
    """Read, update, write, record: once a cycle."""

    def __init__(
        self,
        controller: Controller,
        devices: LiveDevices,
        recorder: RecorderClient | None,
        clock: CycleClock,
        cycle_s: float,
    ) -> None:
        self._controller = controller
        self._devices = devices
        self._recorder = recorder
        self._clock = clock
        self._cycle_s = cycle_s
        self._link_every = max(1, round(_LINK_EVERY_S / cycle_s))
        self._next_link = 0
        self._cycles = 0
        self._lateness, self._compute = MicrosecondHistogram(), MicrosecondHistogram()

    def run(self, finished: Callable[[int], bool]) -> None:
        """Cycle until `finished` holds, then fade the command out."""
        cycle, left = self._clock.start(), _FADE_CYCLES
        clock, cycle_s, now = self._clock, self._cycle_s, time.monotonic
        while left:
            woke = now()
            read = self._devices.read(cycle)
            if finished(cycle):
                left -= 1
                read.reference_rad_s, read.damping_allowed = 0.0, False
            answered = self._controller.step(read)
            self._devices.write(answered.command_rad_s)
            answered_at = now()
            self._record(read, answered)
            self._cycles += 1
            self._lateness.add(woke - clock.origin_s - cycle * cycle_s)
            self._compute.add(answered_at - woke)
            cycle = clock.wait(cycle)
        self._record_loop(cycle * cycle_s)

    def _record(self, read: CycleInput, answered: CycleOutput) -> None:
        recorder = self._recorder
        if recorder is None:
            return
        cycle_s = self._cycle_s
        recorder.put(_FAST, fast_sample(read, answered, cycle_s))
        recorder.put(_ESTIMATE, estimate_sample(read.cycle, answered, cycle_s))
        for sample in read.samples:
            recorder.put(_FRAMES, frame_sample(sample, read.cycle, cycle_s))
        if read.cycle >= self._next_link:
            self._next_link = read.cycle + self._link_every
            counts = self._devices.link_counts
            recorder.put(
                _LINK,
                LinkSample(
                    time_s=read.cycle * cycle_s,
                    cycle=read.cycle,
                    deadline_misses=self._clock.misses,
                    accelerometer_faults=self._devices.accelerometer_faults,
                    recorder_lost=recorder.lost,
                    recorder_alive=recorder.alive(),
                    **counts,
                    **self._devices.link_status(),  # type: ignore[arg-type]
                ),
            )

    def _record_loop(self, time_s: float) -> None:
        if self._recorder is not None:
            lateness, compute = self._lateness.summary(), self._compute.summary()
            self._recorder.put(
                _LOOP, LoopSample(time_s, self._cycles, self._clock.misses, *lateness, *compute)
            )

    def summary(self) -> str:
        """One line about the run."""
        counts = self._devices.link_counts
        return (
            f"stillarm controller: {self._cycles} cycles, {self._clock.misses} deadlines missed, "
            f"{counts['accepted']} visual samples, {counts['lost']} lost"
        )


_FAST, _FRAMES = TOPIC_INDEX["/fast"], TOPIC_INDEX["/frames"]
_ESTIMATE, _LINK, _LOOP = TOPIC_INDEX["/estimate"], TOPIC_INDEX["/link"], TOPIC_INDEX["/loop"]
