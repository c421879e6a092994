"""The simulated rig in real time: the plant in this process, the camera in another; it stands in for the hardware.

Accelerometer: registers in shared memory behind an I2C bus "memory:NAME", or a serial port "pty:NAME". Joint: a drive
gateway on UDP, or the emulator of another drive (rig_drive.py). Camera: frames in shared memory. The scenario's clock
starts with the first drive command.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from ctypes import c_double
from math import inf
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import RawValue
from pathlib import Path

import msgspec
import numpy as np

from stillarm.common.files.configuration import (
    Configuration,
    Rig,
    load_configuration,
    load_true_model,
    true_model_path,
)
from stillarm.common.files.driven_joint import commanded_joint
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, length_of
from stillarm.common.files.scenario import Scenario, load_scenario
from stillarm.common.link.link_key import load_key
from stillarm.common.link.udp import UdpSocket
from stillarm.common.memory.left_behind import remove_left_blocks
from stillarm.common.memory.steady_memory import settle_memory
from stillarm.common.process.loop_processor import leave_it_to_the_loop
from stillarm.common.process.priority import raise_priority, run_fifo
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.header import live_header
from stillarm.common.recording.topics import TOPIC_INDEX, TrueFrame
from stillarm.common.user_error import UserError
from stillarm.controller.loop.schedule import CycleClock
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer
from stillarm.simulation.arm.ahead import ready_plant
from stillarm.simulation.arm.disturbance import DISTURBANCE_STREAM, Disturbance
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.camera.camera_process import pose_history_name
from stillarm.simulation.camera.camera_process import run as run_camera
from stillarm.simulation.camera.camera_timing import AFTER_DELIVERY_S, CameraTiming
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.recording.clock_steps import (
    refuse_step_of_absent_stamps,
    refuse_step_of_controller_clock,
)
from stillarm.simulation.recording.truth import strike_line, true_state
from stillarm.simulation.rig.rig_drive import RigDrive, rig_drive
from stillarm.simulation.rig.strike_requests import StrikesOnRequest, strikes_name
from stillarm.simulation.sensors.accelerometer_effects import accelerometer_effects
from stillarm.simulation.sensors.accelerometer_model import presented_by, with_device
from stillarm.simulation.sensors.accelerometer_signal import ACCELEROMETER_STREAM, AccelerometerSignal

_STATE, _FRAMES, _LOG = TOPIC_INDEX["/truth/state"], TOPIC_INDEX["/truth/frames"], TOPIC_INDEX["/log"]
# Hardware is never late; the program under test must not be on its account. SCHED_FIFO: the camera gives way to the
# plant only, and the supervisor to both.
_NICENESS, _PRIORITY, _CAMERA_PRIORITY = -10, 40, 39
_LONGEST_CATCH_UP = 1000  # cycles: a rig that was stopped for longer goes on from where it was
_LOOKS = 10  # a cycle, for the first command
# cycles from the first command to the plant's step; it comes later in its cycle than those that follow
_AFTER_COMMAND = 0.3
# cycles from a step to the instant it is made for, the controller's next reading: commands come 0.2 to 0.4 after their
# cycle's start. Sensors, poses and truth then hold for the instant at which they are read, as a data sheet says, and a
# command acts from its own cycle on, as the model says.
AHEAD = 0.4


def run(
    configuration_path: Path,
    truth_path: Path | None,
    *,
    seed: int | None,
    scenario: str | None,
    accelerometer: str | None = None,
) -> None:
    """Be the rig until SIGTERM or SIGINT. `seed`, `scenario`, `accelerometer`: in place of the configuration's.

    Raises UserError.
    """
    configuration = load_configuration(configuration_path)
    rig = configuration.rig
    if seed is not None or scenario is not None:
        rig = msgspec.structs.replace(
            rig, seed=rig.seed if seed is None else seed, scenario=scenario or rig.scenario
        )
        configuration = msgspec.structs.replace(configuration, rig=rig)
    name = str(true_model_path(configuration, configuration_path))
    model = declared(load_true_model(configuration, configuration_path))
    commanded_joint(model, name)
    length_of(model, name)
    refuse_step_of_absent_stamps(model, rig, name)
    refuse_step_of_controller_clock(model, name)
    if accelerometer is not None:
        device = presented_by(configuration.accelerometer, accelerometer)
        configuration = msgspec.structs.replace(configuration, accelerometer=device)
        model = msgspec.structs.replace(model, accelerometer=with_device(model.accelerometer, device))
    # raises here what the camera's process would refuse: here the message still reaches the user
    CameraTiming(model.camera, model.timing, rig, rig.seed, origin_s=0.0, after_delivery_s=AFTER_DELIVERY_S)
    remove_left_blocks()
    raise_priority(_NICENESS)
    leave_it_to_the_loop()
    stop = StopSignal()
    recorder = None
    if truth_path is not None:
        header = live_header(configuration_path, configuration, 0, 0.0, seed=rig.seed)
        header = msgspec.structs.replace(header, model=Path(name).read_text(encoding="utf-8"))  # the true one
        recorder = RecorderClient.start(truth_path, header)
    try:
        plant = _PlantProcess(configuration, model, load_scenario(rig.scenario), rig, name)
        camera, frames = _start_camera(configuration, model, rig.seed, plant.started_s)
        settle_memory()
        run_fifo(_PRIORITY)
        try:
            plant.run(stop, recorder, frames, camera.is_alive)
        finally:
            camera.terminate()
            camera.join(5.0)
            plant.close()
            _record_frames(recorder, frames)
    finally:
        if recorder is not None:
            recorder.close()


def fall_into_step(clock: CycleClock, following: int, cycle_s: float, drive: RigDrive) -> None:
    """Wait for the drive's first command, no longer than to the following cycle; put that a third of a cycle after it.

    Otherwise the offset of two clocks, which differs from run to run, would decide whether commands act a cycle late,
    and no model of the rig states that.
    """
    while (left := clock.origin_s + following * cycle_s - time.monotonic()) > 0.0:
        time.sleep(min(left, cycle_s / _LOOKS))
        seen_s = time.monotonic()
        drive.poll(seen_s)
        if drive.commanded:
            clock.origin_s = seen_s + (_AFTER_COMMAND - following) * cycle_s
            return


class _PlantProcess:
    """The plant with its sensors and its drive, step by step in real time."""

    def __init__(
        self, configuration: Configuration, model: Model, scenario: Scenario, rig: Rig, name: str = "model"
    ) -> None:
        """`name` stands for the model's file in messages."""
        if configuration.camera.driver != "shared_memory":
            raise UserError(
                f"camera.driver = {configuration.camera.driver!r}: the simulated rig needs 'shared_memory'"
            )
        self._cycle_s = model.timing.cycle_s
        self._plant = ready_plant(model, name)
        self._plant.effect_clock = EffectClock.waiting()
        self.started_s = RawValue(c_double, inf)
        """When the first command came, on the monotonic clock: the recording's start, for the camera's process."""
        self._signal = AccelerometerSignal(
            model.accelerometer,
            self._cycle_s,
            np.random.default_rng((rig.seed, ACCELEROMETER_STREAM)),
            accelerometer_effects(model, self._cycle_s, rig.seed),
        )
        generator = np.random.default_rng((rig.seed, DISTURBANCE_STREAM))
        scripted = Disturbance(scenario, len(model.arm.modes), self._cycle_s, generator, rig.scenario)
        self._device = configuration.accelerometer
        key = load_key(configuration.link)
        with contextlib.ExitStack() as undo:
            # The port first: where it is another rig's, so is all else, which is not to be replaced.
            self._claim = None
            if configuration.drive.driver != "udp_gateway":
                place = configuration.drive.gateway_host, configuration.drive.gateway_port
                self._claim = UdpSocket(place, "drive.gateway_port")
                undo.callback(self._claim.close)
            self._drive = rig_drive(configuration.drive, key, model.drive.kind)
            undo.callback(self._drive.close)
            self._accelerometer = emulate_accelerometer(self._device, self._cycle_s)
            undo.callback(self._accelerometer.close)
            self._poses = PoseHistory(pose_history_name(configuration), create=True)
            undo.callback(self._poses.close)
            self._disturbance = StrikesOnRequest(scripted, strikes_name(configuration))
            undo.pop_all()
        self._first_command_s: float | None = None

    def run(
        self,
        stop: StopSignal,
        recorder: RecorderClient | None,
        frames: Connection,
        camera_alive: Callable[[], bool],
    ) -> None:
        """Step the plant at every cycle of the clock, as many steps as cycles have passed."""
        clock = CycleClock(self._cycle_s, time.monotonic())
        stepped, cycle = 0, clock.start()
        while not stop:
            behind = min(cycle - stepped, _LONGEST_CATCH_UP)
            now = clock.origin_s + (cycle + AHEAD) * self._cycle_s
            command = self._drive.poll(now)
            if self._first_command_s is None and self._drive.commanded:
                self._first_command_s = now
                self._plant.effect_clock.origin_s = self._plant.time_s
                self.started_s.value = now
            for late in range(behind - 1, -1, -1):
                self._step(now - late * self._cycle_s, command, recorder)
            stepped = cycle
            self._drive.report(self._plant.encoder_position_rad, self._plant.encoder_velocity_rad_s)
            _record_frames(recorder, frames)
            if not camera_alive():
                raise UserError("the rig's camera process ended; its message above tells why")
            if self._first_command_s is None:
                fall_into_step(clock, cycle + 1, self._cycle_s, self._drive)
            cycle = clock.wait(cycle)

    def _step(self, time_s: float, command: float, recorder: RecorderClient | None) -> None:
        """Move the plant on to an instant under a command, and let its sensors show it."""
        plant = self._plant
        if self._first_command_s is not None:
            since = time_s - self._first_command_s
            for strike in self._disturbance.act_on(plant, since):
                if recorder is not None:
                    recorder.put(_LOG, strike_line(strike, time_s - self._cycle_s))
        plant.advance(command)
        felt = self._signal.sample(plant.tip_acceleration_m_s2, plant.effect_time_s, plant.tip_angle_rad)
        self._accelerometer.publish(sensed_axes(felt, self._device))
        self._poses.append(time_s, plant.tip_position_m, plant.tip_angle_rad)
        if recorder is not None:
            recorder.put(_STATE, true_state(plant, time_s))

    def close(self) -> None:
        """Release sockets and shared memory."""
        self._drive.close()
        if self._claim is not None:
            self._claim.close()
        self._accelerometer.close()
        self._poses.close()
        self._disturbance.close()


def _record_frames(recorder: RecorderClient | None, frames: Connection) -> None:
    try:
        while frames.poll():
            frame = TrueFrame(*frames.recv())
            if recorder is not None:
                recorder.put(_FRAMES, frame)
    except (EOFError, OSError):  # the camera's process has ended
        return


def _start_camera(
    configuration: Configuration, model: Model, seed: int, started_s: c_double
) -> tuple[multiprocessing.process.BaseProcess, Connection]:
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(
        target=_camera_main, args=(configuration, model, seed, sender, started_s), name="camera", daemon=True
    )
    process.start()
    sender.close()
    return process, receiver


def _camera_main(
    configuration: Configuration,
    model: Model,
    seed: int,
    frames: Connection,
    started_s: c_double,
) -> None:
    stop = StopSignal()
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches the whole group; the plant's process tells this one

    plant = os.getppid()
    settle_memory()
    run_fifo(_CAMERA_PRIORITY)

    def report(frame: TrueFrame) -> None:
        with contextlib.suppress(BrokenPipeError):  # the plant's process is gone; finished() sees it
            frames.send((frame.time_s, frame.frame, frame.mid_exposure_s, frame.delivered_s))

    def finished() -> bool:
        return stop.is_set() or os.getppid() != plant

    try:
        run_camera(configuration, model, seed, finished, report, started=lambda: started_s.value)
    except UserError as error:
        print(f"stillarm rig: {error}", file=sys.stderr, flush=True)
        sys.exit(1)
