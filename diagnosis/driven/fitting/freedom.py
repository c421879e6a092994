"""What a recording's sensors can show: which numbers of the linear model, and which motion a cause would act on."""

from collections.abc import Callable

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.own import named_in
from stillarm.diagnosis.driven.recording.regression import JOINT, scale_is_open
from stillarm.diagnosis.driven.recording.signals import MEASURED_INPUTS, Driven

STATED = "stated"  # a number of a grey box whose structure a model file states


def has_joint(driven: Driven) -> bool:
    """Whether a sensor looks at the joint itself."""
    return any(one.kind in JOINT for one in driven.outputs)


def needs_mode(driven: Driven) -> bool:
    """Whether a sensor looks at the arm's bending."""
    return any(one.kind in ("deflection", "acceleration") for one in driven.outputs)


def free_of(box: GreyBox) -> tuple[str, ...]:
    """The numbers of the linear model that the sensors can show."""
    driven, free = box.driven, ["gain", "damping", "delay"]
    bends = any(one.kind == "deflection" for one in driven.outputs)
    for i in range(1, box.modes + 1):
        free += [f"log_w_{i}", f"zeta_{i}"]
        free += [f"follows_{i}"] if bends else []
        if has_joint(driven):
            free.append(f"carries_{i}")
    if not has_joint(driven):
        free = [one for one in free if one not in ("damping", "gain" if bends else "")]
    positions = [one for one in driven.outputs if one.kind in ("position", "motor")]
    for one in driven.outputs:
        first_position = bool(positions) and one is positions[0]
        if not first_position:
            free.append(f"offset {one.name}")
        if one.kind == "acceleration":
            free += [f"direct {one.name}"] if has_joint(driven) else []
            free.append(f"jump {one.name}")
            free += [f"share_{i} {one.name}" for i in range(1, box.modes + 1)]
            if not has_joint(driven) and not bends and box.modes:
                free.remove("gain")
        elif (
            one.kind in ("velocity", "motor")
            and positions
            and not first_position
            and scale_is_open(one, positions[0])
        ):
            free.append(f"scale {one.name}")
    offsets = [one for one in free if one.startswith("offset ")]
    free = [one for one in free if one not in box.declared]
    free += [named_in(one, k) for k in range(1, driven.recordings) for one in offsets]
    return tuple(free)


def shows(*kinds: str) -> Callable[[DrivenFit], bool]:
    """Whether there is a sensor of one of these kinds."""
    return lambda fitted: any(one.kind in kinds for one in fitted.box.driven.outputs)


def before_amplifier(fitted: DrivenFit) -> bool:
    """Whether the input is what the amplifier was told: a measured current or torque came out of it."""
    return fitted.box.driven.drive not in MEASURED_INPUTS


def shows_joint(fitted: DrivenFit) -> bool:
    """Whether a sensor moves with the joint: at it, or an accelerometer on an arm that does not bend."""
    rigid = fitted.box.modes == 0 and shows("acceleration")(fitted)
    return rigid or has_joint(fitted.box.driven)


def shows_angle(fitted: DrivenFit) -> bool:
    """Whether a sensor shows by how much the joint turns: its angle, or a velocity that is known in rad/s."""
    known = STATED in fitted.numbers
    velocities = [one for one in fitted.box.driven.outputs if one.kind == "velocity"]
    return shows("position", "motor")(fitted) or any(known or one.stated for one in velocities)


def shows_bending(fitted: DrivenFit) -> bool:
    """Whether a sensor looks at an arm that bends."""
    return fitted.box.modes > 0 and needs_mode(fitted.box.driven)


def shows_link(fitted: DrivenFit) -> bool:
    """Whether anything shows what the link does."""
    return shows_joint(fitted) or shows_bending(fitted)
