"""The catalogue of causes: what can make a rig depart from its model, by identifier, as [[effects]] of a model file.

t is time on the controller's clock from the recording's start. "replaces" means: the total value that takes the
declared one's place. docs/causes.md tells the same for people.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Literal

Place = Literal["arm", "drive", "accelerometer", "camera", "timing"]
Value = float | int | bool | str


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a cause; its unit is its name's suffix.

    lowest, highest: what a model file may say, both included
    typical: sizes worth looking for on an ordinary rig, taken from `neutral` on, to both sides where signed
    neutral: the value at which nothing happens; NaN for a replacement, which is neutral at the declared value
    default: of an optional parameter; None: required
    choices: of a text; kind: how the value is written
    """

    name: str
    unit: str
    lowest: float = 0.0
    highest: float = 0.0
    typical: tuple[float, float] = (0.0, 0.0)
    signed: bool = False
    neutral: float = 0.0
    default: Value | None = None
    kind: Literal["number", "whole", "truth", "text"] = "number"
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Cause:
    """A physical cause: where it sits, its parameters, what one sees of it, and its equation or rule.

    repeatable: whether a model may hold several effects of it.
    """

    identifier: str
    place: Place
    parameters: tuple[Parameter, ...]
    sees: str
    equation: str
    repeatable: bool = False


def _size(
    name: str,
    unit: str,
    highest: float,
    low: float,
    high: float,
    *,
    signed: bool = False,
    neutral: float = 0.0,
) -> Parameter:
    return Parameter(name, unit, -highest if signed else 0.0, highest, (low, high), signed, neutral)


def _replacing(name: str, unit: str, lowest: float, highest: float, low: float, high: float) -> Parameter:
    return Parameter(name, unit, lowest, highest, (low, high), neutral=float("nan"))


def _frequency(low: float, high: float) -> Parameter:
    return Parameter("frequency_hz", "Hz", 0.01, 1000.0, (low, high))


_ONSET = Parameter("onset_s", "s", 0.0, 1e7)
_OTHERS = Parameter("higher_modes_share", "1", -10.0, 10.0, (0.0, 1.0), default=1.0)
_PHASE = Parameter("phase_rad", "rad", -1e3, 1e3, (0.0, 2.0 * pi), default=0.0)


def _arm() -> Iterator[Cause]:
    yield Cause(
        "second_bending_mode",
        "arm",
        (
            Parameter("frequency_hz", "Hz", 0.01, 400.0, (10.0, 25.0)),
            Parameter("damping_ratio", "1", 0.0, 0.999, (0.005, 0.03)),
            Parameter("participation", "1", -10.0, 10.0, (0.1, 0.3), signed=True),
        ),
        "after a quick move the arm also rings at a higher frequency, which dies away sooner",
        "one more q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i length theta''",
        repeatable=True,
    )
    yield Cause(
        "coulomb_damping",
        "arm",
        (_size("force_per_mass_m_s2", "m/s^2", 100.0, 0.01, 0.05),),
        "the ring-down's amplitude falls along a straight line and then stops, instead of fading out",
        "q_1'' -= force sign(q_1'); at rest it holds against as much",
    )
    yield Cause(
        "quadratic_damping",
        "arm",
        (_size("coefficient_per_m", "1/m", 1e4, 1.0, 10.0),),
        "large vibrations die away faster than small ones, as in air or water",
        "q_1'' -= coefficient q_1' |q_1'|",
    )
    yield Cause(
        "cubic_stiffness",
        "arm",
        (_size("coefficient_per_m2", "1/m^2", 1e7, 100.0, 600.0, signed=True),),
        "the frequency changes with the amplitude: a stiffening arm rings faster the farther it swings",
        "q_1'' -= w_1^2 coefficient q_1^3",
    )
    yield Cause(
        "payload_change",
        "arm",
        (
            _ONSET,
            Parameter("frequency_ratio", "1", 0.1, 10.0, (0.03, 0.15), signed=True, neutral=1.0),
            _OTHERS,
        ),
        "from an instant on the arm rings at another frequency: something was taken up or put down",
        "from onset on f_1 times ratio, f_i times 1 + share (ratio - 1); damping ratios stay",
        repeatable=True,
    )
    yield Cause(
        "stiffness_drift",
        "arm",
        (_size("frequency_rate_hz_per_s", "Hz/s", 10.0, 0.0005, 0.004, signed=True), _OTHERS),
        "the frequency creeps up or down all along, as when the arm warms",
        "f_1(t) = f_1 + rate t; the other modes by share of that, in proportion",
    )
    yield Cause(
        "periodic_disturbance",
        "arm",
        (_frequency(1.0, 6.0), _size("amplitude_m_s2", "m/s^2", 1e3, 0.1, 0.5), _PHASE),
        "the arm never comes to rest but goes on swinging at a foreign frequency, as beside a pump",
        "q_1'' += amplitude sin(2 pi frequency t + phase)",
        repeatable=True,
    )


def _drive() -> Iterator[Cause]:
    yield Cause(
        "drive_dead_time",
        "drive",
        (_replacing("dead_time_s", "s", 0.0, 1.0, 0.01, 0.04),),
        "the joint answers its command later than declared, by the same time at every frequency",
        "replaces drive.dead_time_s",
    )
    yield Cause(
        "drive_lag",
        "drive",
        (_replacing("bandwidth_hz", "Hz", 0.01, 1e9, 3.0, 10.0),),
        "the joint's velocity rounds off every corner of its command more, or less, than declared",
        "replaces drive.bandwidth_hz",
    )
    yield Cause(
        "drive_saturation",
        "drive",
        (_replacing("max_velocity_rad_s", "rad/s", 1e-6, 1e9, 0.05, 0.15),),
        "fast moves are cut off at a velocity below the declared limit",
        "replaces drive.max_velocity_rad_s",
    )
    yield Cause(
        "drive_deadband",
        "drive",
        (_size("deadband_rad_s", "rad/s", 10.0, 0.005, 0.02),),
        "small commands do nothing at all, larger ones are obeyed in full",
        "a command of |c| <= deadband is obeyed as 0, others unchanged",
    )
    yield Cause(
        "gear_backlash",
        "drive",
        (
            _size("gap_rad", "rad", 1.0, 0.002, 0.01),
            Parameter("behind_encoder", "", default=False, kind="truth"),
        ),
        "after every reversal the joint stands still for a moment and then starts with a jerk",
        "play of total width gap: theta stands while the motor crosses it; the encoder is the joint's, or the "
        "motor's where behind_encoder",
    )
    yield Cause(
        "joint_friction",
        "drive",
        (_size("velocity_loss_rad_s", "rad/s", 10.0, 0.005, 0.02),),
        "the joint is slower than its command by the same amount at every speed, and ignores small ones",
        "a command c is obeyed as sign(c) max(0, |c| - loss)",
    )


def _accelerometer() -> Iterator[Cause]:
    yield Cause(
        "accelerometer_bias_drift",
        "accelerometer",
        (_size("rate_m_s3", "m/s^3", 1e3, 0.005, 0.05, signed=True),),
        "the accelerometer's zero creeps away",
        "a += rate t",
    )
    yield Cause(
        "accelerometer_sensitivity_drift",
        "accelerometer",
        (_size("rate_per_s", "1/s", 10.0, 0.002, 0.008, signed=True),),
        "the same vibration reads larger, or smaller, as time goes on",
        "scale (1 + rate t)",
    )
    yield Cause(
        "accelerometer_clipping",
        "accelerometer",
        (_replacing("range_m_s2", "m/s^2", 1e-6, 1e9, 1.2, 4.0),),
        "the peaks of the acceleration are cut off flat below the declared range",
        "replaces accelerometer.range_m_s2",
    )
    yield Cause(
        "accelerometer_lag",
        "accelerometer",
        (_replacing("delay_s", "s", 0.0, 1.0, 0.005, 0.03),),
        "the acceleration trails the motion by more, or less, than declared",
        "replaces accelerometer.delay_s",
    )
    yield Cause(
        "gravity_leakage",
        "accelerometer",
        (_size("gain_m_s2_per_rad", "m/s^2 a rad", 100.0, 1.0, 9.8, signed=True),),
        "the acceleration at rest depends on the pose: the sensor tilts and feels gravity",
        "a += gain (theta + slope of the tip)",
    )
    yield Cause(
        "mains_hum",
        "accelerometer",
        (_frequency(45.0, 65.0), _size("amplitude_m_s2", "m/s^2", 1e3, 0.2, 1.0), _PHASE),
        "a steady tone in the acceleration that no image shows",
        "a += amplitude sin(2 pi frequency t + phase)",
        repeatable=True,
    )
    yield Cause(
        "impulse_noise",
        "accelerometer",
        (
            _size("rate_hz", "1/s", 1e3, 0.2, 3.0),
            _size("amplitude_m_s2", "m/s^2", 1e6, 4.0, 15.0),
        ),
        "single samples of the acceleration are far off, at no particular time",
        "at Poisson instants one sample of +-amplitude, of random sign, is added",
        repeatable=True,
    )


def _camera() -> Iterator[Cause]:
    yield Cause(
        "tracking_drift",
        "camera",
        (_size("rate_px_per_s", "px/s", 1e3, 0.02, 0.3, signed=True),),
        "the image creeps away although the tip returns to its place",
        "d += rate t",
    )
    yield Cause(
        "lens_distortion",
        "camera",
        (_size("coefficient_per_px2", "1/px^2", 1.0, 2e-7, 2e-6, signed=True),),
        "far from the image's zero the same motion shows larger, or smaller",
        "d becomes d (1 + coefficient d^2)",
    )
    yield Cause(
        "camera_tilt_coupling",
        "camera",
        (Parameter("rotation_px_per_rad", "px a rad", -1e9, 1e9, (50.0, 300.0), True, float("nan")),),
        "the image moves with the angle of the tip as well as with its position",
        "replaces camera.rotation_px_per_rad",
    )


def _timing() -> Iterator[Cause]:
    yield Cause(
        "camera_clock_skew",
        "timing",
        (_size("skew_ppm", "ppm", 1e5, 100.0, 800.0, signed=True),),
        "the frames come a little slower, or faster, than the declared rate, evenly",
        "frame period T (1 + 1e-6 skew)",
    )
    yield Cause(
        "frame_drops",
        "timing",
        (Parameter("fraction", "1", 0.0, 0.95, (0.03, 0.3)),),
        "frames are missing singly; a counter of exposures shows the gaps",
        "each frame is lost with that probability",
    )
    yield Cause(
        "delay_bursts",
        "timing",
        (
            _size("rate_hz", "1/s", 100.0, 0.1, 0.5),
            _size("duration_s", "s", 100.0, 0.1, 0.5),
            _size("delay_s", "s", 10.0, 0.03, 0.1),
        ),
        "now and then the frames come late for a while, and then catch up",
        "bursts begin at Poisson instants; while one lasts, frames come delay later, in their order",
    )
    yield Cause(
        "delay_drift",
        "timing",
        (_size("rate_s_per_s", "s/s", 0.1, 2e-4, 1e-3, signed=True),),
        "the capture delay grows, or shrinks, all along",
        "delay += rate t",
    )
    yield Cause(
        "stale_frame_buffer",
        "timing",
        (_ONSET, Parameter("frames", "frames", 0.0, 32.0, (1.0, 3.0), kind="whole")),
        "from an instant on every image is one or more frames older than it claims",
        "from onset on the image handed over as k is exposure k - frames",
    )
    yield Cause(
        "clock_step",
        "timing",
        (
            _ONSET,
            _size("step_s", "s", 10.0, 0.02, 0.2, signed=True),
            Parameter("clock", "", default="frames", kind="text", choices=("frames", "camera", "all")),
        ),
        "one clock jumps against the others at an instant",
        'from onset on step is added to received_s and started_s ("frames"), to captured_s ("camera"), or to every '
        'time in both files ("all")',
        repeatable=True,
    )


CAUSES: dict[str, Cause] = {
    cause.identifier: cause
    for group in (_arm(), _drive(), _accelerometer(), _camera(), _timing())
    for cause in group
}
"""All of them, in the catalogue's order."""
