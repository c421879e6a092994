"""The controller's process: the loop around the step, with clock, devices and recorder at its edge."""

import os
import secrets
import signal
import time
from pathlib import Path

from stillarm.common.files.configuration import (
    is_simulated_rig,
    load_assumed_model,
    load_configuration,
    model_path,
)
from stillarm.common.files.effects import not_used_by_controller
from stillarm.common.memory.left_behind import remove_left_blocks
from stillarm.common.process.loop_processor import send_beside_the_loop
from stillarm.common.process.service_notify import notify
from stillarm.common.process.single_instance import hold_instance
from stillarm.common.process.stop_signal import SignalFlag, StopSignal
from stillarm.common.recorder.recorder_client import RECORDING_CUT, RecorderClient
from stillarm.common.recorder.structured_log import log, log_start
from stillarm.common.recording.header import live_header
from stillarm.common.user_error import UserError
from stillarm.controller.loop.live_devices import LiveDevices
from stillarm.controller.loop.loop import Loop
from stillarm.controller.loop.realtime import RealTime, missing_privileges
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.loop.step import Controller
from stillarm.controller.loop.warm_up import warm_up
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.statistics_process import (
    start_statistics,
    stop_statistics,
    wait_until_loaded,
)

_LEAD_S = 0.2  # from the end of the warm-up to cycle 0; the recorder opens its file in that time
_EMPTIED_BEFORE_S = 0.005  # before cycle 0: datagrams until then do not belong to this run

_NOT_ARMED = (
    "the joint stands still until `stillarm operate arm --config FILE`, as controller.arm_at_start is false"
)


def run(
    configuration_path: Path, record: Path | None, duration_s: float | None, *, allow_non_realtime: bool
) -> None:
    """Run until SIGTERM or SIGINT, or for `duration_s`. Raises UserError for a user's mistake."""
    configuration = load_configuration(configuration_path)
    _refuse_without_privileges(allow_non_realtime)
    model = load_assumed_model(configuration, configuration_path)
    cycle_s = model.timing.cycle_s
    model_name = str(model_path(configuration, configuration_path))
    controller = Controller(
        model, configuration.controller, model_name, identified_only=not is_simulated_rig(configuration)
    )
    hold_instance("controller", configuration.link.controller_port)
    remove_left_blocks()
    devices = LiveDevices(configuration, model, SignalFlag(signal.SIGUSR1), model_name)
    stop = StopSignal()
    recorder = statistics = None
    block = LoopBlock(f"loop-{os.getpid()}-{secrets.token_hex(4)}", create=True)
    realtime = RealTime()
    try:
        devices.start()
        recorder = RecorderClient.launch()
        statistics = start_statistics(block.name, recorder.process_id, configuration.telemetry)
        warm_up(model, configuration.controller, model_name)
        wait_until_loaded(statistics)
        recorder.wait_until_loaded()
        # Only now: the loop's processor is free until the first cycle, and a rig and a supervisor that run already may
        # leave them hardly any time on the others.
        for child in (recorder.process_id, statistics.pid):
            send_beside_the_loop(child)
        log_start("controller", configuration, configuration_path)
        for note in filter(None, (not_used_by_controller(model), *devices.notes)):
            log("controller", "warning", note)
        if not configuration.controller.arm_at_start:
            log("controller", "info", _NOT_ARMED)
        if missing := realtime.enter():
            log("controller", "warning", "not real-time", missing=[str(each) for each in missing])
        clock = CycleClock(cycle_s, time.monotonic() + _LEAD_S)
        header = live_header(configuration_path, configuration, devices.session, clock.origin_s)
        recorder.begin(record, header, telemetry=configuration.telemetry, process_name="controller")
        loop = Loop(controller, devices, recorder, block, clock, cycle_s)
        last = None if duration_s is None else int(duration_s / cycle_s)
        notify("READY=1")
        time.sleep(max(0.0, clock.origin_s - _EMPTIED_BEFORE_S - time.monotonic()))
        devices.empty_queues()
        loop.run(lambda cycle: bool(stop) or (last is not None and cycle >= last))
        notify("STOPPING=1")
        print(loop.summary(), flush=True)
    finally:
        devices.close()
        realtime.leave()
        if recorder is not None and not recorder.close() and record is not None:
            log("controller", "error", RECORDING_CUT, recording=str(record), lost=recorder.lost)
        if statistics is not None:
            stop_statistics(statistics)
        block.close()


def _refuse_without_privileges(allow_non_realtime: bool) -> None:
    """Check the privileges before anything is opened. Raises UserError with the missing ones and their remedy."""
    missing = missing_privileges()
    if missing and not allow_non_realtime:
        raise UserError(
            f"controller: no real-time operation: {'; '.join(map(str, missing))}; or start with --allow-non-realtime"
        )
