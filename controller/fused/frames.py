"""Images: which law dates them, what they add, and what follows for the delay."""

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.configuration import Fused
from common.model import Model
from common.visual_sample import VisualSample
from controller.fused import start
from controller.fused.bank import LAWS, FilterBank, Law, Seen
from controller.fused.blocks import Block
from controller.fused.dating import Dating
from controller.fused.joint_input import JointInput
from controller.fused.layout import Layout
from controller.joint_motion import JointMotion

Array = NDArray[np.float64]

_MEMORY_FRAMES = 60.0  # of the evidence for one law against another
_OUTLIER = 16.0
_MISCOUNT_COST = 10.0
_FEWEST_WEIGHT = 1e-4
_CLEAR = 0.995


class Merged(NamedTuple):
    """The laws' common state: phasors, slow rates (laws merged), bias, and covariance of the whole."""

    phasors: list[complex]
    slow: list[complex]
    bias: float
    bias_variance: float
    covariance: list[list[float]]
    edge_s: float


class FrameFusion:
    """Takes in images and, in their order, the accelerometer's blocks before them."""

    def __init__(self, model: Model, settings: Fused, at: Layout, length_m: float) -> None:
        """Nothing seen yet."""
        self._at, self._model, self._settings = at, model, settings
        self.dating = Dating(start.frame_s(model), model.timing.capture_delay_s)
        self._first_variance = start.variances(model, settings, at, length_m)
        self.bank = FilterBank(at, np.zeros((LAWS, at.size)), self._first_variance, start.jitters_s(model))
        self._shift_noise = start.shift_noise(model)
        self._state_noise = start.state_noise(settings, at)
        clock = 0.75 if model.camera.mode == "freerun" else 0.1
        rest = (1.0 - clock) / 3.0
        self._prior = np.log(np.array((clock, 1e-300, rest, rest, rest)))
        self._evidence = np.zeros(LAWS)
        self.weights = np.exp(self._prior)
        self._noise_m2 = (at.per_px * model.camera.noise_std_px) ** 2
        self.delay_s = model.timing.capture_delay_s
        self.delay_std_s = start.first_shift_s(model)
        self.amplitude_m = 0.0
        self._outliers = 0
        self._strange = np.zeros(LAWS)
        self._arrival_mean, self._arrival_variance = self.delay_s, start.first_shift_s(model) ** 2
        self.reason = ""
        self.blow: tuple[float, float] | None = None

    # --- accelerometer

    def take_block(self, block: Block) -> None:
        """The oldest block not yet taken in."""
        bank, at = self.bank, self._at
        if block.jump_m:
            bank.inflate(block.jump_m, block.start_s)
        if block.count:
            bank.take_block(block, block.variance)
        dt = block.end_s - bank.edge_s
        noise = self._state_noise * dt
        noise[at.phasor] = self.phasor_noise() * dt
        bank.move_on(block, noise)

    def phasor_noise(self) -> float:
        """Growth of the variance of each phasor component, m^2/s."""
        return (self._settings.disturbance_share * self.amplitude_m) ** 2 + self._noise_m2 * 0.1

    # --- images

    def expected_instant_s(self) -> float:
        """When the frame accepted last was exposed, by the most likely law."""
        best = int(np.argmax(self.weights))
        return float(self.dating.nominal[best] + self.bank.x[best, self._at.shift])

    def accept(self, sample: VisualSample, received_s: float) -> bool:
        """Date a frame (also one without a measurement, for its count); False for one not to be used."""
        first = not self.dating.started
        if not self.dating.accept(sample, received_s):
            return False
        if first:
            return True
        dating, t = self.dating, self._at.shift
        elapsed = dating.elapsed
        self.bank.advance_dating(elapsed, self._shift_noise * np.abs(elapsed), 1e-14)
        if dating.doubt_s:
            self.bank.p[Law.CLOCK, t, t] += dating.doubt_s**2
        if dating.stamp_broken:
            self.bank.p[Law.STAMPS, t, t] += (2.0 * dating.frame_s) ** 2
        if dating.stamped and self._prior[Law.STAMPS] < -100.0:
            self._prior[Law.STAMPS] = 0.0
            self.bank.copy_law(
                int(np.argmax(self.weights)), Law.STAMPS, 0.0, start.first_shift_s(self._model) ** 2,
                self._first_variance[Law.STAMPS, self._at.skew],
            )  # fmt: skip
            best = int(np.argmax(self.weights))
            dating.nominal[Law.STAMPS] = dating.nominal[best] + self.bank.x[best, t]
        return True

    def take(
        self, sample: VisualSample, received_s: float, joint: JointMotion, joint_input: JointInput, suspicion: float
    ) -> None:
        """A measured frame, accepted before, with all blocks before its exposure taken in."""
        at, bank = self._at, self.bank
        value = sample.displacement_x_px * at.per_px
        if not self.dating.started or bank.x[0, at.offset] == 0.0:
            bank.x[:, at.offset] = value - at.lever * joint.position_at(received_s - self.delay_s)
        noise = self._noise_m2
        if isfinite(sample.variance_x_px2) and sample.variance_x_px2 > 0.0:
            noise = max(noise, at.per_px**2 * sample.variance_x_px2)
        times = self.dating.nominal + bank.x[:, at.shift]
        seen = self._look(value, times, joint, joint_input, noise)
        seen = self._count_again(value, times, received_s, joint, joint_input, noise, seen)
        surprise = seen.surprise
        best = int(np.argmax(self.weights))
        self.blow = None
        if surprise[best] > _OUTLIER and float(surprise[self.weights > 0.05].min()) > 9.0:
            self._outliers += 1
            if self._outliers < 2 and suspicion < 7.0:
                return  # one image alone may be wrong; two are a blow
            size = abs(float(seen.residual[best]))
            self.blow = (times[best], size)
            bank.inflate(1.5 * size, times[best])
            seen = self._look(value, times, joint, joint_input, noise)
            surprise = np.minimum(surprise, 4.0)
        self._outliers = 0
        self._weigh(surprise, seen)
        own, spread = bank.take_image(seen, np.maximum(1.0, seen.surprise / 12.0))
        instants = self.dating.nominal + bank.x[:, at.shift] + own
        self._tell_delay(received_s - instants, spread)
        self._respawn(received_s)

    def _look(self, value: float, times: Array, joint: JointMotion, joint_input: JointInput, noise: float) -> Seen:
        at, edge = self._at, self.bank.edge_s
        instants = times.tolist()
        joint_m = np.array([joint.position_at(t) for t in instants]) * at.lever
        rate = np.array([joint.position_at(t + 0.002) - joint.position_at(t - 0.002) for t in instants])
        step = np.empty((LAWS, at.modes), dtype=np.complex128)
        for i in range(at.modes):
            base = joint_input.at(i, edge)
            step[:, i] = [joint_input.at(i, t) - base for t in instants]
        return self.bank.look(value, times, joint_m, rate * (at.lever / 0.004), step, noise)

    def _count_again(
        self, value: float, times: Array, received_s: float, joint: JointMotion, joint_input: JointInput,
        noise: float, seen: Seen,
    ) -> Seen:  # fmt: skip
        """Frames lost or doubled that the counter does not tell of: another count if image and arrival both say so."""
        frame, t = self.dating.frame_s, self._at.shift
        std = sqrt(float(self.bank.p[Law.CLOCK, t, t]))
        if seen.surprise[Law.CLOCK] < 9.0 or std > frame / 5.0 or self.weights[Law.CLOCK] < 0.05:
            return seen
        costs: list[tuple[float, int]] = []
        for extra in (-2, -1, 0, 1, 2, 3):
            moved = times.copy()
            moved[Law.CLOCK] += extra * frame
            surprise = float(self._look(value, moved, joint, joint_input, noise).surprise[Law.CLOCK])
            late = received_s - float(moved[Law.CLOCK]) - self._arrival_mean
            costs.append((surprise + late * late / self._arrival_variance + (_MISCOUNT_COST if extra else 0.0), extra))
        _, extra = min(costs)
        if extra == 0:
            return seen
        self.dating.nominal[Law.CLOCK] += extra * frame
        times[Law.CLOCK] += extra * frame
        return self._look(value, times, joint, joint_input, noise)

    def _weigh(self, surprise: Array, seen: Seen) -> None:
        keep = 1.0 - 1.0 / _MEMORY_FRAMES
        log = -0.5 * (np.minimum(surprise, 25.0) + np.log(seen.variance))
        self._evidence = keep * self._evidence + log
        self._evidence -= self._evidence.max()
        np.maximum(self._evidence, -60.0, out=self._evidence)
        total = self._prior + self._evidence
        weights = np.exp(total - total.max())
        self.weights = weights / weights.sum()

    def _tell_delay(self, delays: Array, spread: Array) -> None:
        w = self.weights
        mean = float(w @ delays)
        variance = float(w @ (spread + (delays - mean) ** 2))
        self.delay_s, self.delay_std_s = mean, sqrt(variance)
        if variance < (0.2 * self.dating.frame_s) ** 2:
            late = mean - self._arrival_mean
            self._arrival_mean += 0.03 * late
            self._arrival_variance += 0.03 * (late * late - self._arrival_variance)
            self._arrival_variance = max(self._arrival_variance, 0.001**2)

    def _respawn(self, received_s: float) -> None:
        """A law that the images have refuted starts again from what the best one knows."""
        best = int(np.argmax(self.weights))
        t, k = self._at.shift, self._at.skew
        for law in range(LAWS):
            if self.weights[law] > _FEWEST_WEIGHT or (law == Law.STAMPS and not self.dating.stamped):
                self._strange[law] = 0.0
                continue
            self._strange[law] += 1.0
            if self._strange[law] < _MEMORY_FRAMES:
                continue
            self._strange[law] = 0.0
            instant = received_s - self.delay_s
            shift = instant - float(self.dating.nominal[law])
            variance = max(self.delay_std_s, 0.001) ** 2
            if law >= Law.STEADY:
                shift = float(self.bank.x[best, t]) if best >= Law.STEADY else -(self.delay_s - self._model.timing.capture_delay_s)
            self.bank.copy_law(best, law, shift, variance, float(self._first_variance[law, k]))
            self._evidence[law] = -7.0

    def merged(self, now_s: float) -> Merged:
        """Phasors at the bank's instant, with the covariance that they have at now_s for want of newer images."""
        bank, at, w = self.bank, self._at, self.weights
        best = int(np.argmax(w))
        if w[best] > _CLEAR:
            x, p = bank.x[best], bank.p[best]
        else:
            x = w @ bank.x
            d = bank.x - x
            p = np.tensordot(w, bank.p, 1) + (d * w[:, None]).T @ d
        m = at.modes
        z = x[at.cosine] - 1j * x[at.sine]
        lag = now_s - bank.edge_s
        f = np.eye(at.size)[: 2 * m]
        for i in range(m):
            c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
            f[c, kw], f[s, kw] = -lag * z[i].imag, -lag * z[i].real
            f[c, kd], f[s, kd] = -lag * z[i].real, lag * z[i].imag
        covariance = f @ p @ f.T
        covariance[range(2 * m), range(2 * m)] += self.phasor_noise() * lag
        self.amplitude_m = float(np.abs(z).sum())
        slow = -at.sigma - x[at.decay] + 1j * x[at.frequency]
        return Merged(
            z.tolist(), slow.tolist(), float(x[at.bias]), float(p[at.bias, at.bias]), covariance.tolist(), bank.edge_s
        )
