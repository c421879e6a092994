"""What physics and a rig's sampling allow the numbers of a grey box."""

from collections.abc import Iterable, Mapping
from math import inf, isfinite

from stillarm.diagnosis.driven.greybox import GreyBox
from stillarm.diagnosis.driven.own import base_of, named_in, recording_of

LEAST_ZETA, MOST_ZETA = 1e-5, 0.3  # of an arm that rings
LEAST_SHARE = 0.02  # of the motor in the inertia of motor and hub
MOST_BOUNCE = 0.8  # of the velocity at which teeth meet
LEAST_INERTIA, MOST_INERTIA = -0.8, 10.0  # of what it was, that an inertia changes by
SLOWEST_STRIBECK, QUICKEST_STRIBECK = (
    -12.0,
    10.0,
)  # log of rad/s: beyond, friction is the same at all speeds of a rig
LEAST_CYCLES = 1e-6  # 1/rad, of gravity behind an unknown gear: no gear turns a motor so often
_NEAR = 0.02  # of the way from one bound to the other: no size that a rig has, but where a fit was stopped
LONGEST_DELAY_S = 0.5  # of a cause
LONGEST_SAMPLES = 1.5  # of a delay without a cause


def within(numbers: dict[str, float], box: GreyBox) -> dict[str, float]:
    """Numbers inside what physics allows, and a rig's sampling: half a step early, where a sample means an average."""
    h = box.driven.step_s
    for marked, value in numbers.items():
        name, recording = base_of(marked), recording_of(marked)
        if name.startswith("zeta_"):
            numbers[marked] = min(max(value, LEAST_ZETA), MOST_ZETA)
        elif name in _NEVER_NEGATIVE or name.startswith("lag"):
            numbers[marked] = max(value, 0.0)
        elif name.startswith("carries_"):
            numbers[marked] = min(max(value, 0.0), 50.0)
        elif name == "gravity_cycles":
            numbers[marked] = max(value, LEAST_CYCLES)
        elif name == "onset":
            numbers[marked] = min(max(value, 0.0), box.driven.duration_s)
        elif name == "bounce":
            numbers[marked] = min(max(value, 0.0), MOST_BOUNCE)
        elif name == "share":
            numbers[marked] = min(max(value, LEAST_SHARE), 1.0 - LEAST_SHARE)
        elif name in ("inertia_step", "inertia_excess"):
            numbers[marked] = min(max(value, LEAST_INERTIA), MOST_INERTIA)
        elif name == "delay":
            cause = "late" if recording is None else named_in("late", recording)
            late = LONGEST_DELAY_S if numbers.get(cause, 0.0) else LONGEST_SAMPLES * h
            numbers[marked] = min(max(value, -h), late)
        elif name == "log_stribeck_velocity":
            numbers[marked] = min(max(value, SLOWEST_STRIBECK), QUICKEST_STRIBECK)
        elif name.startswith("log_w_"):
            numbers[marked] = min(max(value, -3.0), 8.5)
    return numbers


def believable(names: Iterable[str], numbers: Mapping[str, float], step_s: float) -> bool:
    """Whether none of the named numbers stands at a bound of what a rig may have, and no sensor's delay or lag is finer
    than what is known of the input between its samples, which are step_s apart."""
    for marked in names:
        name, value = base_of(marked), numbers.get(marked, numbers.get(base_of(marked), 0.0))
        if name.startswith(_OF_A_SENSOR) and abs(value) < _FINEST * step_s:
            return False
        low, high = _BOUNDS.get(name.partition(" ")[0], (-inf, inf))
        near = _NEAR * (high - low) if isfinite(high - low) else 0.0
        if not low + near <= value <= high - near:
            return False
    return True


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
_NEVER_NEGATIVE = ("coulomb", "stribeck", "dead_zone", "dead_cut", "limit", "arm_coulomb", "damping", "gap")
