"""An image on its way into the filters: what each stage hands to the next, and how an image is compared.

Implements Eqs. 4, 30 of docs/fused.md.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.filters.image_update import (
    Seen,
    Vibration,
    look_at_image,
    vibration_at,
)
from stillarm.controller.estimation.fused.fusion.state import FusionState

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Look(NamedTuple):
    """What an image is compared with."""

    value_m: float
    noise: float
    joint_input: JointInput


class Joint(NamedTuple):
    """What the joint did by an image's instants: how far it alone moved the tip, m, at what rate, m/s, both (filters,);
    and the modes' phasor increments since the bank's instant, (filters, m). tip_variance, rate_variance: of both, by
    the encoder's noise, m^2 and m^2/s^2."""

    tip: Array
    rate: Array
    tip_variance: float
    rate_variance: float
    step: ComplexArray


class Aimed(NamedTuple):
    """An image to be predicted next. times: its instant by each filter, s."""

    image: Look
    times: Array
    received_s: float
    joint: Joint


class PredictedImage(NamedTuple):
    """An image to be looked at next, and what each filter expects it to show."""

    aimed: Aimed
    vibration: Vibration


class Looked(NamedTuple):
    """An image looked at, to be processed next. times: its instant by each filter, s; nis: (filters,)."""

    image: Look
    times: Array
    received_s: float
    seen: Seen
    nis: Array


class Taken(NamedTuple):
    """An image processed, to be settled next. own, s, and spread, s^2: of its own instant, as image_update.take_image
    gives them; nis: as the evidence is to weigh it; each (filters,)."""

    own: Array
    spread: Array
    seen: Seen
    nis: Array
    received_s: float


def joint_at(state: FusionState, image: Look, times: Array) -> Joint:
    """What the joint did by an image's instants (filters,)."""
    lever, motion = state.at.lever, image.joint_input
    theta, rate, step = motion.seen_from(state.bank.edge_s, times)
    squared = lever * lever
    return Joint(
        theta * lever, rate * lever, squared * motion.position_variance, squared * motion.rate_variance, step
    )


def joint_still(state: FusionState, image: Look, times: Array) -> bool:
    """Whether the joint moves too slowly to date the image, by the most likely filter."""
    best = state.evidence.best
    _, rate, _ = image.joint_input.seen_from(state.bank.edge_s, times[best : best + 1])
    return (
        abs(float(rate[0])) * state.at.lever
        < state.assumed.update.still * state.at.w_first * state.amplitude_m
    )


def compared(state: FusionState, image: Look, vibration: Vibration, joint: Joint) -> Seen:
    """The image as each filter sees it, where the arm vibrates and the joint moves so."""
    noise = image.noise + joint.tip_variance
    return look_at_image(
        state.bank, image.value_m, vibration, joint.tip, joint.rate, joint.rate_variance, noise
    )


def compared_at(state: FusionState, image: Look, times: Array) -> Seen:
    """The image as each filter sees it, exposed at times (filters,)."""
    joint = joint_at(state, image, times)
    return compared(state, image, vibration_at(state.bank, times, joint.step), joint)
