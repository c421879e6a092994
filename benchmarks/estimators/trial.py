"""One trial of one method: runs the controller's own step on the generator's data, and scores it against the truth."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot, nan
from time import perf_counter_ns

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.world.generator import Data, Frames, cycle_times
from stillarm.benchmarks.estimators.world.regimes import (
    ACCELEROMETER_SCALE_STD,
    AFTER_IMPACT_S,
    CAMERA_SCALE_STD,
    CYCLE_S,
    SETTLING_S,
    Arm,
    Regime,
)
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Accelerometer, Camera, Commissioned, Mode, Model
from stillarm.common.files.model import Arm as ArmModel
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.replay.frame_delays import FrameDelays

Values = NDArray[np.float64]
Mask = NDArray[np.bool_]
LAST_S = 10.0
LENGTH_M = 2.0
SCALE_PX_PER_M = 800.0
_ANSWERED_CYCLES = 20  # cycles within which a method dates a frame


@dataclass(frozen=True)
class Answers:
    """A method's estimates. Shapes (cycles,), and (frames,) for delays: stillarm.controller.replay.frame_delays.

    trust: the word of each cycle.
    """

    deflection_m: Values
    deflection_std_m: Values
    delay_s: Values
    delay_std_s: Values
    step_us: Values
    trust: NDArray[np.str_]


@dataclass(frozen=True)
class Score:
    """Figures of one trial. Errors of the deflection are fractions of the momentary amplitude.

    The first seven start at SETTLING_S and exclude AFTER_IMPACT_S after each impact; *_all include everything after
    SETTLING_S; error_last: mean over the last LAST_S; unanswered: fraction of cycles without a finite prediction, each
    of which counts as a prediction of zero.
    """

    error_mean: float
    error_max: float
    pmcc: float
    delay_bias_s: float
    delay_rms_s: float
    delay_normalised_error_squared: float
    deflection_normalised_error_squared: float
    error_mean_all: float
    error_max_all: float
    error_last: float
    unanswered: float
    us_mean: float
    us_median: float


def assumed_model(regime: Regime, noise: float, arm: Arm | None = None) -> Model:
    """The model of a commissioned rig: the true parameters, and for the delay only its mean and spread.

    It states how well the sensors' scales are known; their actual error is `scale_error`.
    """
    arm = Arm() if arm is None else arm
    w = arm.angular_frequency
    return Model(
        arm=ArmModel(
            length_m=LENGTH_M, modes=[Mode(frequency_hz=arm.frequency_hz, damping_ratio=arm.damping_ratio)]
        ),
        accelerometer=Accelerometer(
            noise_std_m_s2=noise * w * w * arm.amplitude_m, range_m_s2=arm.range_m_s2
        ),
        camera=Camera(
            mode="triggered" if regime.triggered else "freerun",
            exposure_s=0.0,  # an image of this world shows an instant
            scale_px_per_m=SCALE_PX_PER_M,
            noise_std_px=arm.vision_noise * arm.amplitude_m * SCALE_PX_PER_M,
        ),
        commissioned=Commissioned(
            date="2026-01-01",
            recording="benchmark",
            std={
                "camera.scale_px_per_m": CAMERA_SCALE_STD * SCALE_PX_PER_M,
                "accelerometer.scale": ACCELEROMETER_SCALE_STD,
            },
        ),
    )


def scale_error(seed: tuple[int, ...]) -> float:
    """Error of the image scale relative to the accelerometer's that remains after a trial's commissioning."""
    std = hypot(CAMERA_SCALE_STD, ACCELEROMETER_SCALE_STD)
    return std * float(np.random.default_rng((*seed, 2)).standard_normal())


def visual_sample(frames: Frames, frame: int, seen_m: float, arm: Arm) -> VisualSample:
    """A frame as the supervisor would report it, showing the tip at `seen_m`."""
    variance = (arm.vision_noise * arm.amplitude_m * SCALE_PX_PER_M) ** 2
    return VisualSample(
        frame=int(frames.number[frame]),
        started_cycle=int(frames.started_cycle[frame]),
        status=TrackingStatus.MEASURED,
        displacement_x_px=-SCALE_PX_PER_M * seen_m,
        displacement_y_px=0.0,
        rotation_rad=0.0,
        variance_x_px2=variance,
        variance_y_px2=variance,
        covariance_xy_px2=0.0,
        variance_rotation_rad2=1e-8,
        captured_s=float(frames.stamp_s[frame]),
        exposure_s=0.015,
        features=100,
        inliers=100,
    )


def samples_by_cycle(data: Data, scale_factor: float = 1.0) -> dict[int, list[VisualSample]]:
    """The trial's frames by the cycle that reads them. scale_factor: true image scale over the assumed one.

    A frame counter that goes back means that the supervisor was restarted.
    """
    samples: dict[int, list[VisualSample]] = {}
    before = -1
    for frame, cycle in enumerate(data.frames.read_cycle.tolist()):
        seen = scale_factor * float(data.seen_m[frame])
        sample = visual_sample(data.frames, frame, seen, data.arm)
        if sample.frame < before:
            sample = msgspec.structs.replace(sample, restarted=True)
        before = sample.frame
        samples.setdefault(cycle, []).append(sample)
    return samples


def run_method(name: str, data: Data, model: Model, scale_factor: float = 1.0) -> Answers:
    """Run a method on a trial with the joint at rest. Raises what the method raises."""
    controller = Controller(model, Settings(method=name, arm_at_start=True), "the benchmark's model")
    samples = samples_by_cycle(data, scale_factor)
    acceleration: list[float] = data.acceleration_m_s2.tolist()
    count = len(acceleration)
    said = np.full((3, count), nan)
    nothing: list[VisualSample] = []
    trust: list[str] = []
    delays, of_frame = FrameDelays(), np.full((2, len(data.frames.read_cycle)), nan)
    for cycle in range(count):
        read = CycleInput(cycle, acceleration[cycle], 0.0, 0.0, 0.0, 0.0, False, samples.get(cycle, nothing))
        began = perf_counter_ns()
        estimate = controller.step(read).estimate
        ended = perf_counter_ns()
        trust.append(estimate.trust or "")
        said[:, cycle] = estimate.deflection_m, estimate.deflection_std_m, 1e-3 * (ended - began)
        for frame, delay in delays.told(read.samples, estimate):
            of_frame[:, frame] = delay.delay_s, delay.std_s
    return Answers(said[0], said[1], of_frame[0], of_frame[1], said[2], np.array(trust))


def swinging_cycles(data: Data, from_s: float) -> Mask:
    """The cycles from a time on in which the arm rings freely, neither at rest nor held. Shape (cycles,)."""
    time_s = cycle_times(len(data.deflection_m))
    swinging: Mask = (time_s >= from_s) & (data.amplitude_m > 0.0)
    return swinging & ~forced_cycles(data)


def forced_cycles(data: Data) -> Mask:
    """The cycles under a force that is not an impact. Shape (cycles,)."""
    return within(data.motion.forced_s, cycle_times(len(data.deflection_m)))


def within(spans: Iterable[tuple[float, float]], time_s: Values) -> Mask:
    """Which of the times lie in one of the spans."""
    inside: Mask = np.zeros(len(time_s), np.bool_)
    for begin, end in spans:
        inside |= (time_s >= begin) & (time_s < end)
    return inside


def scored_cycles(data: Data, from_s: float = SETTLING_S) -> Mask:
    """The scored cycles: settled, ringing, and no impact within the last AFTER_IMPACT_S. Shape (cycles,)."""
    time_s = cycle_times(len(data.deflection_m))
    scored = swinging_cycles(data, from_s)
    for impact in data.motion.impacts_s:
        begun = impact - 0.5 * data.arm.impact_s
        scored &= (time_s < begun) | (time_s > begun + AFTER_IMPACT_S)
    return scored


def scored_frames(data: Data, from_s: float = SETTLING_S) -> Mask:
    """The scored frames: read in a scored cycle, and only the last of several in a cycle. Shape (frames,).

    Frames of the last cycles are excluded, since a method may not have had time to date them.
    """
    read = data.frames.read_cycle
    newest: Mask = np.append(read[1:] != read[:-1], True)
    told = read < len(data.deflection_m) - _ANSWERED_CYCLES
    return scored_cycles(data, from_s)[read] & newest & told


def score(data: Data, answers: Answers, from_s: float = SETTLING_S) -> Score:
    """Judge one trial from `from_s` on."""
    said = said_of(data, answers)
    late = swinging_cycles(data, from_s)
    times = float(answers.step_us.mean()), float(np.median(answers.step_us))
    return score_of(said, scored_cycles(data, from_s), late, scored_frames(data, from_s), times)


def said_of(data: Data, answers: Answers) -> "Said":
    """Truth and estimates of a trial; the unit is the momentary amplitude."""
    return Said(
        data.deflection_m, answers.deflection_m, answers.deflection_std_m, data.amplitude_m,
        answers.delay_s - data.frames.delay_s, answers.delay_std_s,
    )  # fmt: skip


@dataclass(frozen=True)
class Said:
    """Truth and estimates: shape (cycles,), the last two (frames,). unit_m: denominator of relative errors."""

    deflection_m: Values
    predicted_m: Values
    predicted_std_m: Values
    unit_m: Values
    delay_error_s: Values
    delay_std_s: Values


def score_of(
    said: Said, cycles: Mask, late: Mask, frames: Mask, times_us: tuple[float, float] = (nan, nan)
) -> Score:
    """Score the estimates in `cycles` and `frames`. late: all cycles after settling."""
    known = np.isfinite(said.predicted_m)
    predicted = np.where(known, said.predicted_m, 0.0)
    error = predicted - said.deflection_m
    # division by zero for an arm at rest, which is not scored
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.abs(error) / said.unit_m
    last = cycles.copy()
    last[: -round(LAST_S / CYCLE_S)] = False
    # A delay that is not finite counts as wrong by its whole length.
    delay_error = np.nan_to_num(said.delay_error_s, nan=Regime.delay_s)[frames]
    with np.errstate(divide="ignore", invalid="ignore"):
        normalised = error / np.where(known, said.predicted_std_m, nan)
        delay_normalised = delay_error / said.delay_std_s[frames]
    return Score(
        float(relative[cycles].mean()),
        float(relative[cycles].max()),
        _correlation(predicted[cycles], said.deflection_m[cycles]),
        float(delay_error.mean()),
        float(np.sqrt(np.mean(delay_error**2))),
        mean_square(delay_normalised),
        mean_square(normalised[cycles]),
        float(relative[late].mean()),
        float(relative[late].max()),
        float(relative[last].mean()) if last.any() else nan,
        float(1.0 - known[late].mean()),
        *times_us,
    )


def mean_square(values: Values) -> float:
    """Of those that are finite; NaN without any."""
    finite = values[np.isfinite(values)]
    return float(np.mean(finite**2)) if len(finite) else nan


def _correlation(a: Values, b: Values) -> float:
    a, b = a - a.mean(), b - b.mean()
    power = float(a @ a) * float(b @ b)
    return float(a @ b) / power**0.5 if power > 0.0 else 0.0
