"""A closed-loop run: the benchmark's plant and camera with the controller's own step."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, floor, nan, pi

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.trial import LENGTH_M, assumed_model, scale_error, visual_sample
from stillarm.benchmarks.estimators.world.generator import expose, vision_errors
from stillarm.benchmarks.estimators.world.plant import amplitude_m, arm_plant, rate_m_s, strike
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, Arm, Regime
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Observation, Status
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.replay.frame_delays import FrameDelays
from stillarm.simulation.arm.plant import Plant

Values = NDArray[np.float64]
ORACLE = "oracle"  # knows the momentary deflection and rate exactly
NO_DAMPING = "no damping"


@dataclass(frozen=True)
class Course:
    """What happens in a run. Functions of time: joint reference, rad/s, and whether damping is allowed.

    strikes: by time, the arm's amplitude after each one, m. force_std_m_s2: of a random force, independent in each
    cycle.
    """

    duration_s: float
    strikes: dict[float, float]
    reference: Callable[[float], float] = lambda time_s: 0.0
    damping: Callable[[float], bool] = lambda time_s: False
    force_std_m_s2: float = 0.0


def to_and_fro(from_s: float, every_s: float, lasts_s: float, peak_rad_s: float) -> Callable[[float], float]:
    """A joint velocity reference, rad/s: moves to and fro in turns, each a raised cosine."""

    def reference(time_s: float) -> float:
        move, since = divmod(time_s - from_s, every_s)
        if move < 0.0 or since > lasts_s:
            return 0.0
        return (1.0 if move % 2 == 0 else -1.0) * peak_rad_s * 0.5 * (1.0 - cos(2.0 * pi * since / lasts_s))

    return reference


@dataclass(frozen=True)
class Run:
    """Results of a run by cycle, shape (cycles,), and by frame, shape (frames,)."""

    deflection_m: Values
    amplitude_m: Values
    predicted_m: Values
    predicted_std_m: Values
    delay_error_s: Values
    delay_std_s: Values
    frame_cycle: NDArray[np.int64]


class _Oracle:
    """The method that reads the plant's state."""

    def __init__(self, plant: Plant, delay_s: float) -> None:
        self._plant = plant
        self._delay = DelayEstimate(delay_s, 0.0, Status.ESTIMATED)

    def update(self, observation: Observation) -> Estimate:
        return Estimate(self._delay, self._plant.deflection_m, rate_m_s(self._plant), 0.0, Status.ESTIMATED)


def run_closed(name: str, regime: Regime, noise: float, seed: tuple[int, ...], course: Course) -> Run:
    """Run method `name`, ORACLE or NO_DAMPING. `seed` gives all of them the same disturbances and errors."""
    arm, model = Arm(), assumed_model(regime, noise)
    random = np.random.default_rng(seed)
    mode, drive = model.arm.modes[0], model.drive
    plant = arm_plant(
        arm, LENGTH_M, mode.participation, drive.bandwidth_hz, round(drive.dead_time_s / CYCLE_S)
    )
    controller = _controller(name, model, plant)
    frames = expose(regime, course.duration_s, random)
    count = round(course.duration_s / CYCLE_S)
    unit = arm.angular_frequency**2 * arm.amplitude_m
    felt = (noise * unit * random.standard_normal(count)).tolist()
    pushed = (course.force_std_m_s2 * random.standard_normal(count)).tolist()
    seen = vision_errors(arm, len(frames.number), random)
    scale = 1.0 + scale_error(seed)
    phases = random.uniform(0.2, 0.8, len(course.strikes)).tolist()
    pending = sorted(course.strikes.items())
    tip, tip_rate = np.empty(count), np.empty(count)
    said = np.full((4, count), nan)
    of_frame = np.full((2, len(frames.number)), nan)
    next_frame, first_seen, delays = 0, 0.0, FrameDelays()
    read_cycle: list[int] = frames.read_cycle.tolist()
    for cycle in range(count):
        time_s = cycle * CYCLE_S
        while pending and pending[0][0] <= time_s:
            _strike(plant, arm, pending.pop(0)[1], phases.pop())
        tip[cycle] = plant.tip_position_m
        tip_rate[cycle] = LENGTH_M * plant.joint_velocity_rad_s + rate_m_s(plant)
        plant.modal_forces_m_s2 = [pushed[cycle]]
        samples = []
        while next_frame < len(read_cycle) and read_cycle[next_frame] <= cycle:
            shown = _between(tip, tip_rate, float(frames.exposed_s[next_frame]), cycle) + float(
                seen[next_frame]
            )
            first_seen = shown if next_frame == 0 else first_seen
            samples.append(visual_sample(frames, next_frame, scale * (shown - first_seen), arm))
            next_frame += 1
        output = controller.step(
            CycleInput(
                cycle, plant.tip_acceleration_m_s2 + felt[cycle],
                plant.joint_position_rad, plant.joint_velocity_rad_s, 0.0,
                course.reference(time_s), course.damping(time_s) and name != NO_DAMPING, samples,
            )
        )  # fmt: skip
        estimate = output.estimate
        said[:, cycle] = (
            plant.deflection_m, amplitude_m(plant, arm), estimate.deflection_m, estimate.deflection_std_m
        )  # fmt: skip
        for frame, delay in delays.told(samples, estimate):
            true_delay = CYCLE_S * read_cycle[frame] - float(frames.exposed_s[frame])
            of_frame[:, frame] = delay.delay_s - true_delay, delay.std_s
        plant.advance(output.command_rad_s)
    told = np.isfinite(of_frame[0])
    return Run(
        said[0], said[1], said[2], said[3], of_frame[0, told], of_frame[1, told], frames.read_cycle[told]
    )


def _controller(name: str, model: Model, plant: Plant) -> Controller:
    if name not in {ORACLE, NO_DAMPING}:
        return Controller(model, Settings(method=name, arm_at_start=True), "the benchmark's model")
    controller = Controller(model, Settings(method="timestamps", arm_at_start=True), "the benchmark's model")
    controller.method = _Oracle(plant, model.timing.capture_delay_s)
    return controller


def _strike(plant: Plant, arm: Arm, wanted_m: float, share: float) -> None:
    """Bring the arm to an amplitude. At rest, `share` (0 to 1) determines the direction of the impact."""
    sign = 1.0 if share > 0.5 else -1.0
    turn = arm.angular_frequency * max(0.0, wanted_m**2 - plant.deflection_m**2) ** 0.5
    strike(plant, arm, sign * turn - rate_m_s(plant))


def _between(position: Values, rate: Values, time_s: float, newest: int) -> float:
    """The tip's position between two cycles, by the cubic through both positions and rates (Hermite)."""
    low = min(max(floor(time_s / CYCLE_S), 0), newest - 1)
    x = time_s / CYCLE_S - low
    a, b = float(position[low]), float(position[low + 1])
    c, d = CYCLE_S * float(rate[low]), CYCLE_S * float(rate[low + 1])
    return a + x * (c + x * (3.0 * (b - a) - 2.0 * c - d + x * (2.0 * (a - b) + c + d)))
