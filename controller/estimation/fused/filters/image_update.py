"""An image predicted, compared and processed by all filters, each at its own instant.

Implements Eqs. 4, 12, 30, 31, 32, 33, 34 of docs/fused.md.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import Array, ComplexArray
from stillarm.controller.estimation.fused.small_arrays import summed


class ObservedImage(NamedTuple):
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


class Vibration(NamedTuple):
    """What each filter expects of the arm at its instant, as an image would show it: lag since edge_s, s, (filters, 1);
    by mode, (filters, m), exp((slow + i w) t) and the phasor turned by it, m; deflection, m, and its rate, m/s,
    (filters,).
    """

    lag: Array
    turn: ComplexArray
    own: ComplexArray
    deflection: Array
    rate: Array


@dataclass(slots=True)
class ImageInnovation:
    """One image as each filter sees it before processing it; arrays of shape (filters,)."""

    residual: Array
    variance: Array
    rate: Array
    ph: Array  # covariance times the slope of the image's value by the state, (filters, n)
    nis: Array  # normalised innovation squared
    phasor: Array  # variance of the first mode's phasor, m^2, the mean of its parts'
    known_rate2: Array  # square of the image's rate, at this instant and on average, m^2/s^2


def turned_to(bank: FilterBank, times_s: Array) -> ComplexArray:
    """Factors that turn a phasor at edge_s into its share of images at times_s (filters, k): shape (filters, k, m)."""
    lag = (times_s - bank.edge_s)[:, :, None]
    turned: ComplexArray = (
        np.exp(bank.fast_rates()[:, None, :] * lag + bank.iw * bank.edge_s) * bank.image_gain
    )
    return turned


def vibration_at(bank: FilterBank, times_s: Array, step: ComplexArray) -> Vibration:
    """What each filter expects of the arm at times_s (filters,). step: joint's phasor increments since edge_s,
    (filters, m).
    """
    z, fast = bank.phasors(), bank.fast_rates()
    lag = (times_s - bank.edge_s)[:, None]
    turn = np.exp(fast * lag.astype(np.complex128) + bank.iw * bank.edge_s) * bank.image_gain
    own = z * turn
    total = own + step * turn
    return Vibration(lag, turn, own, summed(total.real, 1), summed((fast * total).real, 1))


def joint_at(bank: FilterBank, image: ObservedImage, times_s: Array) -> Joint:
    """What the joint did by an image's instants (filters,)."""
    lever, motion = bank.at.lever, image.joint_input
    theta, rate, step = motion.seen_from(bank.edge_s, times_s)
    squared = lever * lever
    return Joint(
        theta * lever, rate * lever, squared * motion.position_variance, squared * motion.rate_variance, step
    )


def compare_image(
    bank: FilterBank, image: ObservedImage, vibration: Vibration, joint: Joint
) -> ImageInnovation:
    """The image as each filter sees it, where the arm vibrates and the joint moves so."""
    at, p, w2 = bank.at, bank.p, bank.at.w_first**2
    blur = np.exp(-0.5 * w2 * bank.jitter)
    scale = 1.0 + bank.x[:, at.scale]
    deflection = vibration.deflection * blur + bank.x[:, at.force]
    tip = joint.tip + deflection
    rate = scale * (joint.rate + vibration.rate)
    slope = np.zeros(bank.x.shape)
    shown, drawn = (scale * blur)[:, None], vibration.lag * -scale[:, None]
    turn, own = vibration.turn, vibration.own
    slope[:, at.cosine], slope[:, at.sine] = turn.real * shown, turn.imag * shown
    slope[:, at.frequency], slope[:, at.decay] = own.imag * drawn, own.real * drawn
    slope[:, at.offset], slope[:, at.scale], slope[:, at.shift] = 1.0, tip, rate
    slope[:, at.force] = scale
    phasor = 0.5 * (p[:, 0, 0] + p[:, 1, 1])
    rate_variance = w2 * phasor + joint.rate_variance
    shift, rate2 = p[:, at.shift, at.shift], rate * rate
    known_rate2 = _known_rate2(bank, rate2)
    untold = shift > bank.assumed.update.shift_untold * bank.first[:, at.shift]
    unseen = untold & (rate_variance > bank.assumed.update.insignificant * known_rate2)
    if unseen.any():
        slope[unseen, at.shift] = 0.0
    residual = image.value_m - scale * tip - bank.x[:, at.offset]
    # second order: products of two uncertain quantities, and a large shift bends the sinusoid
    unknown = bank.jitter + shift
    products = (
        p[:, at.scale, at.scale] * (phasor + rate2 * unknown)
        + (bank.assumed.update.model_floor * deflection) ** 2
    )
    bend = 0.5 * (w2 * deflection * unknown) ** 2
    noise = image.noise + joint.tip_variance
    extra = noise + rate2 * (bank.jitter + unseen * shift)
    extra += rate_variance * unknown + bend + products
    ph = np.matvec(p, slope)
    variance = np.vecdot(ph, slope) + extra
    return ImageInnovation(residual, variance, rate, ph, residual * residual / variance, phasor, known_rate2)


def compare_image_at(bank: FilterBank, image: ObservedImage, times_s: Array) -> ImageInnovation:
    """The same of an image that was exposed at times_s (filters,)."""
    joint = joint_at(bank, image, times_s)
    return compare_image(bank, image, vibration_at(bank, times_s, joint.step), joint)


def update_by_image(
    bank: FilterBank, innovation: ImageInnovation, extra: Array, phase_only: NDArray[np.bool_] | None
) -> tuple[Array, Array]:
    """Process what `look` saw, with variance enlarged by the factors `extra` (filters,).

    phase_only: filters whose dates the image cannot correct, (filters,); None for none.

    Returns what each filter then holds of this frame's own instant beyond its shift: mean, s, and the variance
    of the instant as a whole, s^2; each (filters,).
    """
    t = bank.at.shift
    ph, variance = innovation.ph, innovation.variance * extra
    gain = ph / variance[:, None]
    vague = _vague(bank, innovation)
    if phase_only is not None:
        vague |= phase_only
    if vague.any():
        for i in (t, bank.at.skew, bank.at.late, bank.at.ahead):
            gain[vague, i] = 0.0
        both = gain[:, :, None] * ph[:, None, :]
        bank.p -= both + both.transpose(0, 2, 1)
        bank.p += gain[:, :, None] * (gain * variance[:, None])[:, None, :]
    else:
        bank.p -= gain[:, :, None] * ph[:, None, :]
    bank.x += gain * innovation.residual[:, None]
    own = innovation.rate * bank.jitter / variance
    spread = bank.p[:, t, t] + bank.jitter - own * own * variance - 2.0 * own * ph[:, t]
    return own * innovation.residual, np.maximum(spread, 1e-14)


def _vague(bank: FilterBank, innovation: ImageInnovation) -> NDArray[np.bool_]:
    """Which filters know the vibration's rate too badly to tell an instant by it, (filters,).

    Phase and instant look alike in an image. Linearised about a wrong rate, as behind an impact, each image would
    seem to tell them apart; the dating then is a consider parameter (Schmidt, 1966): its doubt counts, but it
    stays.
    """
    result: NDArray[np.bool_] = (
        innovation.phasor > (bank.assumed.update.vague / bank.at.w_first**2) * innovation.known_rate2
    )
    return result


def _known_rate2(bank: FilterBank, rate2: Array) -> Array:
    """Square of the image's rate as each filter has it, at this instant (rate2) and on average, m^2/s^2, (filters,)."""
    a, b = bank.x[:, 0], bank.x[:, 1]
    result: Array = (0.5 * bank.at.w_first**2) * (a * a + b * b) + rate2
    return result
