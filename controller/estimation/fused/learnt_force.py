"""How strong a steady random force is that nobody measures: wind, a motor's rumble, a hand that steadies the arm.

A white force changes the modes' rates, however small the vibration is: a small impact each instant. Where it is
stronger than the filter takes it for, the images' innovations are larger than their stated variances. So its intensity
q follows each normalised innovation squared e (innovations; Mehra, IEEE Trans. Automatic Control 15, 1970):

    log q += 0.06 (min(16, e) - 1.1)

The accelerometer shows the force itself: what it moves the phasor by and what it adds to the samples are one thing,
and the Kalman gain takes their covariance in (correlated process and measurement noise; Jazwinski, Stochastic
Processes and Filtering Theory, 1970, section 7.3). With u = (sum f dt) / w, of variance q dt, and the mean force of a
block shown as e = -mean f / w^2, cov(u, e) = -q / w.

Without a force it sinks to a floor so far below what matters that chance does not lift it from there, nor an impact:
only what lasts for a second or so, and what the filters cannot follow by another frequency or decay.
"""

from math import exp, log, sqrt

from stillarm.controller.estimation.fused.blocks import Block, Jump, along_rate

_RATE, _USUAL, _LARGEST_NIS = 0.06, 1.1, 16.0
_FLOOR, _OF_NO_MATTER = 1e-4, 0.03  # of an image's variance, a second
_MOST = 1e6
_FIRST_IMAGES = 65


class LearntForce:
    """intensity: growth of the variance of the first mode's rate over w, m^2/s; zero where it does not matter."""

    def __init__(self, w: list[float], image_m2: float, sample_m2: float) -> None:
        """w: angular frequencies of the modes, rad/s, (m,). image_m2: variance of an image's noise, m^2; sample_m2: of
        an accelerometer's sample as deflection, without any force."""
        self._w = w
        self._sample_m2 = sample_m2
        self._shares = [w[0] / one for one in w]  # the force gives all modes' rates the same
        self._unmoved = (0.0,) * len(w)
        self._image_m2 = image_m2
        self._least, self._most = log(_FLOOR), log(_MOST)
        self._images = 0
        self.restart()

    def restart(self) -> None:
        """There is none, as far as is known."""
        self._log = self._least
        self.intensity = 0.0

    def see(self, nis: float) -> None:
        """An image's innovation squared over its variance, by the filter believed."""
        self._images += 1
        if self._images < _FIRST_IMAGES:
            return
        learnt = self._log + _RATE * (min(nis, _LARGEST_NIS) - _USUAL)
        self._log = min(max(learnt, self._least), self._most)
        q = exp(self._log)
        self.intensity = q * self._image_m2 if q > _OF_NO_MATTER else 0.0

    def during(self, start_s: float, end_s: float) -> Jump | None:
        """What the force does to the phasors in that time, a short one, as an impact in its middle; None: nothing."""
        if self.intensity == 0.0:
            return None
        std = sqrt(self.intensity * (end_s - start_s))
        return Jump(0.5 * (start_s + end_s), tuple([std * one for one in self._shares]), self._unmoved)

    def shown(self, block: Block) -> tuple[float, float] | None:
        """Covariance, m^2, of what the force does to the phasor in a block with what it adds to the block's value.

        For the phasor's parts a and b; as much as the value's variance holds beyond the sensor's own. None: nothing;
        with several modes nobody knows how much of it is whose.
        """
        if self.intensity == 0.0 or block.count == 0 or len(self._w) > 1:
            return None
        w, held_s = self._w[0], block.end_s - block.start_s
        most = w * w * held_s * (block.variance - self._sample_m2 / block.count)
        if most <= 0.0:
            return None
        covariance = -min(self.intensity, most) / w
        moved = covariance * along_rate(w, 0.5 * (block.start_s + block.end_s))
        return moved.real, -moved.imag
