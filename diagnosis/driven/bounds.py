"""What physics and a rig's sampling allow the numbers of a grey box."""

from stillarm.diagnosis.driven.greybox import GreyBox
from stillarm.diagnosis.driven.own import base_of, named_in, recording_of

LEAST_ZETA, MOST_ZETA = 1e-5, 0.3  # of an arm that rings
LONGEST_DELAY_S = 0.5  # of a cause; without one: a sample and a half


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
        elif name == "onset":
            numbers[marked] = min(max(value, 0.0), box.driven.duration_s)
        elif name == "share":
            numbers[marked] = min(max(value, 0.02), 0.98)
        elif name in ("inertia_step", "inertia_excess"):
            numbers[marked] = min(max(value, -0.8), 10.0)
        elif name == "delay":
            cause = "late" if recording is None else named_in("late", recording)
            late = LONGEST_DELAY_S if numbers.get(cause, 0.0) else 1.5 * h
            numbers[marked] = min(max(value, -h), late)
        elif name.startswith("log_w_"):
            numbers[marked] = min(max(value, -3.0), 8.5)
    return numbers


_NEVER_NEGATIVE = ("coulomb", "stribeck", "dead_zone", "dead_cut", "limit", "arm_coulomb", "damping", "gap")
