"""What physics and a rig's sampling allow the numbers of a grey box."""

from collections.abc import Iterable, Mapping
from math import inf, isfinite

from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.greybox.input_path import STEADY
from stillarm.diagnosis.driven.recording.own import base_of, named_in, recording_of

LEAST_ZETA, MOST_ZETA = 1e-5, 0.3  # of an arm that rings
MOST_OFF = 0.7  # log of a mode's frequency over the stated one: beyond half or twice it is another mode
LEAST_SHARE = 0.02  # of the motor in the inertia of motor and hub
MOST_BOUNCE = 0.8  # of the velocity at which teeth meet
LEAST_INERTIA, MOST_INERTIA = -0.8, 10.0  # of what it was, that an inertia changes by
SLOWEST_STRIBECK, QUICKEST_STRIBECK = (
    -12.0,
    10.0,
)  # log of rad/s: beyond, friction is the same at all speeds of a rig
LEAST_CYCLES = 1e-6  # 1/rad, of gravity behind an unknown gear: no gear turns a motor so often
_NEAR = 0.02  # of the way from one bound to the other: no size that a rig has, but where a fit was stopped
LEAST_STICTION = 0.05  # of dry friction, more at rest: less is the width over which friction turns over
LONGEST_DELAY_S = 0.5  # of a cause
LONGEST_SAMPLES = 1.5  # of a delay without a cause


def within(numbers: dict[str, float], box: GreyBox) -> dict[str, float]:
    """Numbers inside what physics allows, and a rig's sampling: half a step early, where a sample means an average."""
    for marked, value in numbers.items():
        low, high = _limits(marked, numbers, box)
        if not low <= value <= high:
            numbers[marked] = min(max(value, low), high)
    return numbers


def _limits(marked: str, numbers: Mapping[str, float], box: GreyBox) -> tuple[float, float]:
    """The least and the most that a number may be, by its name."""
    name, recording = base_of(marked), recording_of(marked)
    if name == "onset":
        return 0.0, box.driven.duration_s
    if name == "delay":
        cause = "late" if recording is None else named_in("late", recording)
        h = box.driven.step_s
        return -h, LONGEST_DELAY_S if numbers.get(cause, 0.0) else LONGEST_SAMPLES * h
    if name.startswith("log_w_"):
        known = numbers.get(f"stated_{name}")
        return _LOG_W if known is None else (known - MOST_OFF, known + MOST_OFF)
    if name in _LIMITS:
        return _LIMITS[name]
    return next(
        (limits for begins, limits in _LIMITS_OF_MANY.items() if name.startswith(begins)), (-inf, inf)
    )


def believable(names: Iterable[str], numbers: Mapping[str, float], step_s: float) -> bool:
    """Whether none of the named numbers stands at a bound of what a rig may have, and no sensor's delay or lag is finer
    than what is known of the input between its samples, which are step_s apart."""
    for marked in names:
        name, value = base_of(marked), numbers.get(marked, numbers.get(base_of(marked), 0.0))
        if name.startswith(_OF_A_SENSOR) and abs(value) < _FINEST * step_s:
            return False
        if name == "stribeck" and value < LEAST_STICTION * _beside(marked, "coulomb", numbers):
            return False
        low, high = _BOUNDS.get(name.partition(" ")[0], (-inf, inf))
        near = _NEAR * (high - low) if isfinite(high - low) else 0.0
        if not low + near <= value <= high - near:
            return False
    return True


def _beside(marked: str, name: str, numbers: Mapping[str, float]) -> float:
    """Another number where the first one holds: in all recordings, or in one of them."""
    recording = recording_of(marked)
    own = name if recording is None else named_in(name, recording)
    return numbers.get(own, numbers.get(name, 0.0))


_OF_A_SENSOR = ("delay ", "lag ")
_FINEST = 0.05  # of a sample
_BOUNDS = {  # in each number's own unit; a delay within 2 % of the longest was stopped there
    "share": (LEAST_SHARE, 1.0 - LEAST_SHARE),
    "inertia_step": (LEAST_INERTIA, MOST_INERTIA),
    "inertia_excess": (LEAST_INERTIA, MOST_INERTIA),
    "log_stribeck_velocity": (SLOWEST_STRIBECK, QUICKEST_STRIBECK),
    "delay": (-inf, 0.98 * LONGEST_DELAY_S),
    "lag": (-inf, 0.98 * LONGEST_DELAY_S),
}
_LOG_W = (-3.0, 8.5)  # log of rad/s: 0.008 Hz to 780 Hz
_NEVER_NEGATIVE = ("coulomb", "stribeck", "dead_zone", "dead_cut", "limit", "arm_coulomb", "damping", "gap")
_LIMITS = dict.fromkeys(_NEVER_NEGATIVE, (0.0, inf)) | {
    "gravity_cycles": (LEAST_CYCLES, inf),
    "bounce": (0.0, MOST_BOUNCE),
    "share": (LEAST_SHARE, 1.0 - LEAST_SHARE),
    STEADY: (0.0, 1.0),  # more is a blow, which makes up for what the first block lacks
    "inertia_step": (LEAST_INERTIA, MOST_INERTIA),
    "inertia_excess": (LEAST_INERTIA, MOST_INERTIA),
    "log_stribeck_velocity": (SLOWEST_STRIBECK, QUICKEST_STRIBECK),
}
_LIMITS_OF_MANY = {  # of modes and sensors, by how their names begin
    "zeta_": (LEAST_ZETA, MOST_ZETA),
    "lag": (0.0, inf),
    "carries_": (0.0, 50.0),  # of the hub's inertia
    "jump ": (0.0, 1.0),
}
