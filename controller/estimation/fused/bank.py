"""Extended Kalman filters side by side, one for each law by which a frame may be dated (docs/fused.md, section 3).

All live at one instant `edge_s`, the end of the last accelerometer block they have taken in, which lies about a
capture delay back: an image is taken in at its own instant, and what the accelerometer has said since is added
afterwards (present.py).
"""

from cmath import exp
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.blocks import Block, Jump, along_rate
from stillarm.controller.estimation.fused.layout import Layout
from stillarm.controller.estimation.fused.quadratic_form import quadratic_form
from stillarm.controller.estimation.fused.reductions import summed

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Law(IntEnum):
    """How the instant of a frame is said to follow."""

    CLOCK = 0  # t0 + k T, k from the frame counter
    STAMPS = 1  # the camera's own stamps
    STEADY = 2  # arrival minus a constant delay
    DRIFT = 3  # arrival minus a wandering delay
    JITTER = 4  # arrival minus a delay of its own for each frame


LAWS = len(Law)
LEVELS = 2  # of unforeseen disturbance: quiet, disturbed
_VAGUE = 0.002  # of the squared rate
_DOUBT_OF_LOST = 0.5  # of the amplitude: of filters found lost
_LEAST_OF_LOST = 0.01  # of the variance at the start, likewise
_UNKNOWN_LATE_S = 0.1
_REDATED = 0.3  # of what dates were found to be off by: its doubt
_UNTOLD = 0.25  # of a shift's first variance: what images have left of it
_INSIGNIFICANT = (
    0.1  # of the squared rate: of less than three deviations, an image's rate is noise, and tells no instant
)
_FLOOR = 0.002  # of the deflection: no image scale or model is better
FILTERS = LAWS * LEVELS  # filter f follows law f % LAWS at level f // LAWS
LAW_OF = np.arange(FILTERS) % LAWS
ALL, QUIET, DISTURBED = slice(None), slice(0, LAWS), slice(LAWS, None)


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


class AimedAtBlock(NamedTuple):
    """An accelerometer block as each filter sees it: its value by each mode's phasor, and by its slow rate, m s; both
    (filters, m); residual, m, (filters,)."""

    gain: ComplexArray
    by_rate: ComplexArray
    residual: Array


@dataclass(slots=True)
class Seen:
    """One image as each filter sees it before taking it in; arrays of shape (filters,)."""

    residual: Array
    variance: Array
    rate: Array
    ph: Array  # covariance times the slope of the image's value by the state, (filters, n)
    nis: Array  # normalised innovation squared
    phasor: Array  # variance of the first mode's phasor, m^2, the mean of its parts'


class FilterBank:
    """States x (filters, n), covariances p (filters, n, n).

    moved: how often each filter's frequencies and decay were changed or loosened otherwise than by a measurement.
    """

    def __init__(self, layout: Layout, variance: Array, jitter_s: Array) -> None:
        """variance: (filters, n) at the start; jitter_s: white spread of each law's instants, s, (filters,)."""
        self._at = layout
        self._diagonal = np.arange(layout.size)
        self._forced = [0, 1, layout.force]  # the first mode's phasor, and the force that it vibrates about
        self._move = np.eye(layout.size)[None, : 2 * layout.modes].repeat(FILTERS, axis=0)
        self.moved = [0] * FILTERS
        self._first, self._first_jitter = variance, jitter_s**2
        self.begin()
        self.edge_s = 0.0
        self._iw, self._minus_sigma = 1j * layout.w, -layout.sigma
        self._image_gain = layout.image_gain.astype(np.complex128)
        self._w_modes = layout.w
        self._w, self._sigma = layout.w.tolist(), layout.sigma.tolist()
        self._per_acceleration = -1.0 / layout.w_first**2

    def begin(self) -> None:
        """As at the start: all states zero."""
        n = self._at.size
        self.x = np.zeros((FILTERS, n))
        self.p = np.zeros((FILTERS, n, n))
        self.p[:, self._diagonal, self._diagonal] = self._first
        self.jitter = self._first_jitter
        self._all_moved()

    def begin_near(self, x: Array) -> None:
        """As at the start, but for the vibration and the image's zero, which are those of the state x (n,)."""
        at = self._at
        phasor, offset = x[at.phasor], float(x[at.offset])
        self.begin()
        self.x[:, at.phasor], self.x[:, at.offset] = phasor, offset
        doubt = _DOUBT_OF_LOST**2 * float(phasor @ phasor)
        i = self._diagonal[at.phasor]
        self.p[:, i, i] = np.minimum(self.p[:, i, i], doubt + _LEAST_OF_LOST * self.p[:, i, i])

    def _all_moved(self) -> None:
        self.moved = [one + 1 for one in self.moved]

    def phasors(self) -> ComplexArray:
        """Z = a - i b of each mode, (filters, m): mode i deflects Re(Z exp(i w t))."""
        pairs: ComplexArray = self.x[:, self._at.phasor].view(np.complex128)
        return pairs.conj()

    def _rates(self) -> ComplexArray:
        """Slow complex rate of each phasor, (filters, m)."""
        at = self._at
        rates = np.empty((FILTERS, at.modes), dtype=np.complex128)  # parts: mixed types cost twice as much
        np.subtract(self._minus_sigma, self.x[:, at.decay], out=rates.real)
        rates.imag = self.x[:, at.frequency]
        return rates

    def aim_at_block(self, block: Block) -> AimedAtBlock:
        """The accelerometer's block that begins at edge_s: z = - sum Re(lambda^2 Z exp(i w t)) / w_1^2 + bias."""
        at = self._at
        z, slow = self.phasors(), self._rates()
        fast = slow + self._iw
        lag = block.time_s - self.edge_s
        gain = fast * fast * np.exp(slow * lag) * (np.array(block.turn) * (-1.0 / at.w_first**2))
        value = z * gain
        residual = block.value - block.forced - summed(value.real, 1) - self.x[:, at.bias]
        return AimedAtBlock(gain, value * (lag + 2.0 / fast), residual)

    def take_block(self, aimed: AimedAtBlock, variance: float, shown: tuple[float, float] | None) -> None:
        """Take in the block that was aimed at last, nothing having changed since; variance, m^2.

        shown: covariance of the block's value with what moves the first mode's phasor meanwhile, m^2.
        """
        at, gain, by_rate = self._at, aimed.gain, aimed.by_rate
        slope = np.zeros(self.x.shape)
        slope[:, at.cosine], slope[:, at.sine] = gain.real, gain.imag
        slope[:, at.frequency], slope[:, at.decay] = -by_rate.imag, -by_rate.real
        slope[:, at.bias] = 1.0
        ph = np.matvec(self.p, slope)
        total = (np.vecdot(ph, slope) + variance)[:, None]
        if shown is not None:
            ph[:, :2] += shown
        weight = ph / total
        self.x += weight * aimed.residual[:, None]
        self.p -= weight[:, :, None] * ph[:, None, :]

    def look_at_block(self, block: Block, one: int) -> tuple[float, float, float, float]:
        """By filter `one`: the block's value without bias and joint, what it should be, what it would be a quarter of a
        period later, and the variance of what it should be."""
        at = self._at
        x: list[float] = self.x[one].tolist()  # plain: of one filter these are too few for arrays
        m, lag, seen = at.modes, block.time_s - self.edge_s, 0j
        row: list[float] = []
        for i, turn in enumerate(block.turn):
            slow = complex(-self._sigma[i] - x[3 * m + i], x[2 * m + i])
            gain = (slow + 1j * self._w[i]) ** 2 * turn * self._per_acceleration
            seen += complex(x[2 * i], -x[2 * i + 1]) * gain * exp(slow * lag)
            row += (gain.real, gain.imag)
        variance = quadratic_form(row, self.p[one, at.phasor, at.phasor].tolist())
        return block.value - block.forced - x[at.bias], seen.real, -seen.imag, variance

    def move_on(self, block: Block, noise: Array) -> None:
        """From the block's start to its end, adding `noise` (filters, n) to the covariances' diagonals."""
        at = self._at
        dt = block.end_s - self.edge_s
        turn = np.exp(self._rates() * dt)
        z = self.phasors() * turn
        f, m = self._move, at.modes  # the rows of the phasors; all else stays
        for i in range(m):
            c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
            by_rate = dt * z[:, i]
            f[:, c, c] = f[:, s, s] = turn.real[:, i]
            f[:, c, s] = turn.imag[:, i]
            f[:, s, c] = -turn.imag[:, i]
            f[:, s, kd] = by_rate.imag
            f[:, c, kw] = -by_rate.imag
            f[:, s, kw] = f[:, c, kd] = -by_rate.real
        z += np.array(block.step) * (0.5 + 0.5 * turn)
        self.x[:, at.cosine], self.x[:, at.sine] = z.real, -z.imag
        p, moved = self.p, f @ self.p
        p[:, at.phasor, :] = moved
        p[:, :, at.phasor] = moved.transpose(0, 2, 1)
        p[:, at.phasor, at.phasor] = moved @ f.transpose(0, 2, 1)
        diagonal = p.reshape(FILTERS, -1)[:, :: at.size + 1]
        diagonal += noise
        self.edge_s = block.end_s

    def symmetrise(self) -> None:
        """Now and then: each measurement leaves the covariances symmetric but for its rounding."""
        self.p = 0.5 * (self.p + self.p.transpose(0, 2, 1))

    def advance_dating(
        self, elapsed_s: Array, shift_return: Array, shift_noise: Array, skew_noise: float
    ) -> None:
        """Frames go on by `elapsed_s` of each filter's clock (filters,): its skew moves its shift.

        shift_noise, skew_noise: growth of the variances, s^2/s and 1/s.
        shift_return: rate at which a wandering delay comes back to its mean, 1/s: without it, a delay that can no
        longer be seen would be thought to wander without bound.
        """
        x, p, t, k, late = self.x, self.p, self._at.shift, self._at.skew, self._at.late
        spent_s = np.abs(elapsed_s)
        back = -np.expm1(-shift_return * spent_s)
        x[:, t] += elapsed_s * x[:, k] - back * (x[:, t] + x[:, late])
        line = p[:, t, :] + elapsed_s[:, None] * p[:, k, :] - back[:, None] * (p[:, t, :] + p[:, late, :])
        own = line[:, t] + elapsed_s * line[:, k] - back * (line[:, t] + line[:, late])
        p[:, t, :] = p[:, :, t] = line
        p[:, t, t] = own + shift_noise * spent_s
        p[:, k, k] += skew_noise * spent_s

    def take_arrival(self, difference_s: Array, noise: Array, walk: Array) -> None:
        """Arrival minus nominal instant minus the model's delay (filters,) = shift + late + noise, variance in s^2.

        walk: growth of the variance of late since the last frame, s^2.
        """
        t, late = self._at.shift, self._at.late
        self.p[:, late, late] += walk
        ph = self.p[:, :, t] + self.p[:, :, late]
        gain = ph / (ph[:, t] + ph[:, late] + noise)[:, None]
        self.x += gain * (difference_s - self.x[:, t] - self.x[:, late])[:, None]
        self.p -= gain[:, :, None] * ph[:, None, :]

    def take_started(self, difference_s: Array, noise: Array, walk: Array) -> None:
        """n_i plus a frame minus nominal instant (filters,) = shift - ahead + noise, variance in s^2.

        walk: growth of the variance of ahead since the last frame, s^2.
        """
        t, ahead = self._at.shift, self._at.ahead
        self.p[:, ahead, ahead] += walk
        ph = self.p[:, :, t] - self.p[:, :, ahead]
        gain = ph / (ph[:, t] - ph[:, ahead] + noise)[:, None]
        self.x += gain * (difference_s - self.x[:, t] + self.x[:, ahead])[:, None]
        self.p -= gain[:, :, None] * ph[:, None, :]

    def first_variance(self, one: int, index: int) -> float:
        """Variance of a state of filter `one` at the start."""
        return float(self._first[one, index])

    def redate(self, later_s: float) -> None:
        """All frames were exposed later_s later than all filters believe, give or take _REDATED of that: so was what
        they show of the vibration. Images tell nothing of it, phase and date go together."""
        at = self._at
        z = self.phasors()
        turned = z * np.exp(-1j * self._w_modes * later_s)
        self.x[:, at.cosine], self.x[:, at.sine] = turned.real, -turned.imag
        self.x[:, at.shift] += later_s
        self.x[:, at.late] -= later_s
        self.doubt_dates((_REDATED * later_s) ** 2)

    def doubt_dates(self, variance: float) -> None:
        """All frames may have been exposed earlier or later, variance in s^2; what they show goes with their dates."""
        at = self._at
        by_date = -1j * self._w_modes * self.phasors()
        direction = np.zeros(self.x.shape)
        direction[:, at.cosine], direction[:, at.sine] = by_date.real, -by_date.imag
        direction[:, at.shift], direction[:, at.late] = 1.0, -1.0
        self.p += variance * direction[:, :, None] * direction[:, None, :]

    def begin_late(self, one: int, late_s: float) -> None:
        """Filter `one`: the mean delay is unknown; arrivals are late_s later than their nominal instants say."""
        t, late = self._at.shift, self._at.late
        self.p[one, late, :] = self.p[one, :, late] = 0.0
        self.p[one, late, late] = _UNKNOWN_LATE_S**2
        self.x[one, late] = late_s - self.x[one, t]

    def place(self, one: int, shift_s: float) -> None:
        """Filter `one`: nothing but arrivals has told of the clock yet, whose shift by them is shift_s."""
        t, late = self._at.shift, self._at.late
        for i in (t, late):
            self.p[one, i, :] = self.p[one, :, i] = 0.0
            self.p[one, i, i] = self._first[one, i]
        self.x[one, t], self.x[one, late] = shift_s, 0.0

    def forget_started(self, variance: float) -> None:
        """n_i has jumped: by how much it is ahead is unknown, variance in s^2."""
        ahead = self._at.ahead
        self.p[:, ahead, :] = self.p[:, :, ahead] = 0.0
        self.p[:, ahead, ahead] = variance

    def fast_rates(self) -> ComplexArray:
        """Complex rate of each mode by each filter, slow + i w, 1/s, (filters, m)."""
        return self._rates() + self._iw

    def turned_to(self, times_s: Array) -> ComplexArray:
        """By what a phasor at edge_s is to be multiplied for what images show of it at times_s (filters, k): shape
        (filters, k, m)."""
        lag = (times_s - self.edge_s)[:, :, None]
        turned: ComplexArray = (
            np.exp(self.fast_rates()[:, None, :] * lag + self._iw * self.edge_s) * self._image_gain
        )
        return turned

    def start_vibration(self, states: list[int], mean: Array, covariance: Array, parts: int) -> None:
        """Take the vibration from a fit to images alone (fresh_fit.Fresh), and the force, where one was fitted, or else
        none. What the fit says of other states moves those that it did not ask for, as far as they are correlated."""
        at = self._at
        known = states[parts:]
        rest = [i for i in range(2 * at.modes, at.size) if i != at.force and i not in known]
        prior = self.p[:, known][:, :, known]
        by_known = np.linalg.solve(prior, self.p[:, known][:, :, rest]).transpose(0, 2, 1)  # of the rest
        own = covariance[:, parts:, parts:]
        self.x[:, rest] += (by_known @ (mean[:, parts:] - self.x[:, known])[:, :, None])[:, :, 0]
        p_rest = self.p[:, rest][:, :, rest] - by_known @ (prior - own) @ by_known.transpose(0, 2, 1)
        cross = by_known @ covariance[:, parts:]  # of the rest with all states of the fit
        self.x[:, at.phasor], self.x[:, at.force] = 0.0, 0.0
        self.p[:] = 0.0
        self.x[:, states] = mean
        at_fit, at_rest = np.array(states), np.array(rest)
        self.p[:, at_fit[:, None], at_fit] = covariance
        self.p[:, at_rest[:, None], at_rest] = p_rest
        self.p[:, at_rest[:, None], at_fit] = cross
        self.p[:, at_fit[:, None], at_rest] = cross.transpose(0, 2, 1)
        self.x[DISTURBED, at.force] = 0.0  # the disturbed filters have none
        self.p[DISTURBED, at.force, :] = self.p[DISTURBED, :, at.force] = 0.0

    def restore(self, x: Array, p: Array, grown: Array) -> None:
        """All but the vibration and the force as they were: x (filters, n), p (filters, n, n), and by how much their
        variances have grown since, (filters, n)."""
        at = self._at
        rest = np.array([i for i in range(2 * at.modes, at.size) if i != at.force])
        self.x[:, rest] = x[:, rest]
        self.p[:] = 0.0
        self.p[:, rest[:, None], rest] = p[:, rest[:, None], rest]
        self.p[:, rest, rest] += grown[:, rest]
        self._all_moved()

    def vibration_at(self, times_s: Array, step: ComplexArray) -> Vibration:
        """What each filter expects of the arm at times_s (filters,). step: joint's phasor increments since edge_s,
        (filters, m).
        """
        z, fast = self.phasors(), self.fast_rates()
        lag = (times_s - self.edge_s)[:, None]
        turn = np.exp(fast * lag.astype(np.complex128) + self._iw * self.edge_s) * self._image_gain
        own = z * turn
        total = own + step * turn
        return Vibration(lag, turn, own, summed(total.real, 1), summed((fast * total).real, 1))

    def look(
        self,
        value_m: float,
        vibration: Vibration,
        joint_m: Array,
        joint_rate: Array,
        joint_rate_variance: float,
        noise: float,
    ) -> Seen:
        """An image that shows value_m of that vibration, when the joint alone moved the tip by joint_m (filters,).

        joint_rate: rate of joint_m, m/s, (filters,), with its variance. noise: of the image, variance, m^2.
        """
        at, p, w2 = self._at, self.p, self._at.w_first**2
        blur = np.exp(-0.5 * w2 * self.jitter)
        scale = 1.0 + self.x[:, at.scale]
        deflection = vibration.deflection * blur + self.x[:, at.force]
        tip = joint_m + deflection
        rate = scale * (joint_rate + vibration.rate)
        slope = np.zeros(self.x.shape)
        shown, drawn = (scale * blur)[:, None], vibration.lag * -scale[:, None]
        turn, own = vibration.turn, vibration.own
        slope[:, at.cosine], slope[:, at.sine] = turn.real * shown, turn.imag * shown
        slope[:, at.frequency], slope[:, at.decay] = own.imag * drawn, own.real * drawn
        slope[:, at.offset], slope[:, at.scale], slope[:, at.shift] = 1.0, tip, rate
        slope[:, at.force] = scale
        phasor = 0.5 * (p[:, 0, 0] + p[:, 1, 1])
        rate_variance = w2 * phasor + joint_rate_variance
        untold = p[:, at.shift, at.shift] > _UNTOLD * self._first[:, at.shift]
        unseen = untold & (rate_variance > _INSIGNIFICANT * self._known_rate2(rate))
        if unseen.any():
            slope[unseen, at.shift] = 0.0
        residual = value_m - scale * tip - self.x[:, at.offset]
        # second order: products of two uncertain quantities, and a large shift bends the sinusoid
        unknown = self.jitter + p[:, at.shift, at.shift]
        rate2 = rate * rate
        products = p[:, at.scale, at.scale] * (phasor + rate2 * unknown) + (_FLOOR * deflection) ** 2
        bend = 0.5 * (w2 * deflection * unknown) ** 2
        extra = noise + rate2 * (self.jitter + unseen * p[:, at.shift, at.shift])
        extra += rate_variance * unknown + bend + products
        ph = np.matvec(p, slope)
        variance = np.vecdot(ph, slope) + extra
        return Seen(residual, variance, rate, ph, residual * residual / variance, phasor)

    def take_image(
        self, seen: Seen, extra: Array, phase_only: NDArray[np.bool_] | None
    ) -> tuple[Array, Array]:
        """Take in what `look` saw, with variance enlarged by the factors `extra` (filters,).

        phase_only: filters whose dating images can tell nothing of, (filters,), if there are any.

        Returns what each filter then holds of this frame's own instant beyond its shift: mean, s, and the variance
        of the instant as a whole, s^2; each (filters,).
        """
        t = self._at.shift
        ph, variance = seen.ph, seen.variance * extra
        gain = ph / variance[:, None]
        vague = self._vague(seen)
        if phase_only is not None:
            vague |= phase_only
        if vague.any():
            for i in (t, self._at.skew, self._at.late, self._at.ahead):
                gain[vague, i] = 0.0
            both = gain[:, :, None] * ph[:, None, :]
            self.p -= both + both.transpose(0, 2, 1)
            self.p += gain[:, :, None] * (gain * variance[:, None])[:, None, :]
        else:
            self.p -= gain[:, :, None] * ph[:, None, :]
        self.x += gain * seen.residual[:, None]
        own = seen.rate * self.jitter / variance
        spread = self.p[:, t, t] + self.jitter - own * own * variance - 2.0 * own * ph[:, t]
        return own * seen.residual, np.maximum(spread, 1e-14)

    def _vague(self, seen: Seen) -> NDArray[np.bool_]:
        """Which filters know the vibration's rate too badly to tell an instant by it, (filters,).

        Phase and instant look alike in an image. Linearised about a wrong rate, as behind an impact, each image would
        seem to tell them apart; the dating then is a consider parameter (Schmidt, 1966): its doubt counts, but it
        stays.
        """
        result: NDArray[np.bool_] = seen.phasor > (_VAGUE / self._at.w_first**2) * self._known_rate2(
            seen.rate
        )
        return result

    def _known_rate2(self, rate: Array) -> Array:
        """Square of the image's rate as each filter has it, at this instant and on average, m^2/s^2, (filters,)."""
        a, b = self.x[:, 0], self.x[:, 1]
        result: Array = (0.5 * self._at.w_first**2) * (a * a + b * b) + rate * rate
        return result

    def inflate(self, jump: Jump, filters: slice = ALL) -> None:
        """An impact has moved the phasors, or a force has changed, by an unknown amount. filters: that are told of the
        force."""
        for i, (along_m, across_m) in enumerate(zip(jump.along_m, jump.across_m, strict=True)):
            along = along_rate(self._w[i], jump.time_s)
            cosine, sine = along.real, -along.imag
            c, d, rest = 2 * i, 2 * i + 1, across_m**2
            power = along_m**2 - rest
            self.p[:, c, c] += power * cosine * cosine + rest
            self.p[:, d, d] += power * sine * sine + rest
            self.p[:, c, d] += power * cosine * sine
            self.p[:, d, c] += power * cosine * sine
        if jump.force_step_m:
            turn = jump.force_step_m * exp(-1j * self._w[0] * jump.time_s)
            self.x[:, self._forced] += (-turn.real, turn.imag, jump.force_step_m)
        if jump.force_m:
            self._change_force(jump, filters)

    def _change_force(self, jump: Jump, filters: slice) -> None:
        """The force changed at the jump's instant, by an unknown amount: neither deflection nor rate jumps with it."""
        turn = exp(1j * self._w[0] * jump.time_s)
        moved = jump.force_m * np.array((-turn.real, -turn.imag, 1.0))
        i = np.array(self._forced)
        self.p[filters, i[:, None], i] += moved[:, None] * moved

    def give_force(self, offset_m: float) -> None:
        """The image's zero has followed a force by about offset_m: that much is the force's, give or take as much.

        Their sum, which images show, stays.
        """
        c, f = self._at.offset, self._at.force
        self.x[:, c] -= offset_m
        self.x[QUIET, f] += offset_m
        doubt = offset_m * offset_m
        self.p[QUIET, c, c] += doubt
        self.p[QUIET, f, f] += doubt
        self.p[QUIET, c, f] -= doubt
        self.p[QUIET, f, c] -= doubt

    def end_force(self) -> None:
        """No force is left: f = 0, taken in as a measurement, for it is correlated with all else."""
        i = self._at.force
        ph = self.p[:, :, i].copy()
        variance = ph[:, i]
        known = variance > 0.0
        gain = np.where(known[:, None], ph / np.where(known, variance, 1.0)[:, None], 0.0)
        self.x -= gain * self.x[:, i, None]
        self.p -= gain[:, :, None] * ph[:, None, :]
        self.x[:, i] = 0.0
        self.p[:, i, :] = self.p[:, :, i] = 0.0

    def forget_zero(self) -> None:
        """Images count from another zero."""
        c = self._at.offset
        self.x[:, c] = 0.0
        self.p[:, c, :] = self.p[:, :, c] = 0.0
        self.p[:, c, c] = self._first[:, c]

    def add(self, increment: list[complex]) -> None:
        """An impact that is known has moved the phasors by `increment`, (m,)."""
        z = np.array(increment)
        self.x[:, self._at.cosine] += z.real
        self.x[:, self._at.sine] -= z.imag

    def forget_phase(self, spread_m: float, x: Array, p: Array, grown: Array) -> None:
        """An impact that the images alone have shown: the vibration is unknown, all else what it was before it to the
        laws that let the delay walk.

        Images taken in before the impact was noticed have moved it, and without an accelerometer nothing would bring it
        back. Delay and frequency stay correlated: a frequency that is off lets the delay walk off through all impacts.
        x, p: before the impact; grown: by how much the variances have grown since, (filters, n).
        """
        at = self._at
        walks, rest = slice(int(Law.DRIFT), None, LAWS), slice(2 * at.modes, at.size)
        self.x[walks, rest] = x[walks, rest]
        self.p[walks, rest, rest] = p[walks, rest, rest]
        self.p[walks, self._diagonal[rest], self._diagonal[rest]] += grown[walks, rest]
        for i in range(2 * at.modes):
            self.p[:, i, :] = self.p[:, :, i] = 0.0
        self.p[:, self._diagonal[at.phasor], self._diagonal[at.phasor]] = spread_m**2

    def loosen(self, filters: slice = ALL) -> None:
        """Frequencies, decay and image scale may have changed, as with a payload or another scene."""
        at = self._at
        for states, spread in (
            (range(2 * at.modes, 3 * at.modes), 0.04 * at.w),
            (range(3 * at.modes, 4 * at.modes), 0.01 * at.w),
            ((at.scale,), np.array([0.1])),
        ):
            for i, one in zip(states, spread.tolist(), strict=True):
                self.p[filters, i, i] = np.maximum(self.p[filters, i, i], one * one)
        self._all_moved()

    def loosen_bias(self, variance: float) -> None:
        """The accelerometer's bias has changed by about the root of variance, m^2."""
        self.p[:, self._at.bias, self._at.bias] += variance

    def start_anew(
        self, target: int, source: int, shift_s: float, variances: tuple[float, float, float]
    ) -> None:
        """Give filter `target` what `source` knows of all but the dating; variances: of shift, skew and late."""
        at = self._at
        self.x[target], self.p[target] = self.x[source], self.p[source]
        for i, variance in zip((at.shift, at.skew, at.late), variances, strict=True):
            self.p[target, i, :] = self.p[target, :, i] = 0.0
            self.p[target, i, i] = variance
            self.x[target, i] = 0.0
        self.x[target, at.shift] = shift_s
        self.moved[target] += 1

    def copy(self, target: int, source: int) -> None:
        """Give filter `target` all that `source` of the same law knows."""
        self.x[target], self.p[target] = self.x[source], self.p[source]
        self.moved[target] += 1
