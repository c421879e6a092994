"""Intensity of a steady random force that no sensor measures: wind, a motor's rumble, a hand that steadies the arm.

Implements Eqs. 48, 49, 50, 51 of docs/fused.md.

A white force changes the modes' rates, however small the vibration is: a small impact each instant. If it is stronger
than the filter assumes, the images' innovations exceed their stated variances. Its intensity q therefore follows each
normalised innovation squared e (innovations; Mehra, IEEE Trans. Automatic Control 15, 1970):

    log q += 0.06 (min(16, e) - 1.1)

The accelerometer shows the force itself: what it moves the phasor by and what it adds to the samples are one thing,
and the Kalman gain contains their covariance (correlated process and measurement noise; Jazwinski, Stochastic
Processes and Filtering Theory, 1970, section 7.3). With u = (sum f dt) / w, of variance q dt, and the mean force of a
block shown as e = -mean f / w^2, cov(u, e) = -q / w.

What else the filters do not follow, as a pull that lasts, passes for such a force in the images. The accelerometer
tells them apart: held over a cycle T, a random force adds the variance q / (w^2 T) to each sample about its block's
mean.

Without a force it sinks to a floor so low that neither chance nor an impact lifts it to a level that matters: only what
lasts for a second or so, and what the filters cannot follow by another frequency or decay.
"""

from math import exp, log, sqrt

from stillarm.controller.estimation.fused.accelerometer.blocks import Block, Jump, along_rate
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class LearntForce:
    """intensity: growth of the variance of the first mode's rate over w, m^2/s; zero where it does not matter.

    random: whether the accelerometer shows that what was learnt is a random force.
    """

    def __init__(
        self,
        w: list[float],
        image_m2: float,
        sample_m2: float,
        cycle_s: float,
        assumed: Assumptions = ASSUMPTIONS,
    ) -> None:
        """w: angular frequencies of the modes, rad/s, (m,). image_m2: variance of an image's noise, m^2; sample_m2: of
        an accelerometer's sample as deflection, without any force, one every cycle_s."""
        self._assumed = assumed.random_force
        self._w = w
        self._sample_m2 = sample_m2
        self._shares = [w[0] / one for one in w]  # the force gives all modes' rates the same
        self._unmoved = (0.0,) * len(w)
        self._image_m2 = image_m2
        self._least, self._most = log(self._assumed.floor), log(self._assumed.most)
        self._images = 0
        self._scatter = sample_m2
        self._per_scatter = w[0] * w[0] * cycle_s
        self.restart()

    def restart(self) -> None:
        """There is none, as far as is known."""
        self._log = self._least
        self.intensity = 0.0

    def see(self, nis: float) -> None:
        """An image's innovation squared over its variance, by the filter believed."""
        self._images += 1
        if self._images < self._assumed.first_images:
            return
        learnt = self._log + self._assumed.rate * (
            min(nis, self._assumed.largest_nis) - self._assumed.usual_nis
        )
        self._log = min(max(learnt, self._least), self._most)
        q = exp(self._log)
        self.intensity = q * self._image_m2 if q > self._assumed.matters else 0.0

    def see_scatter(self, block: Block) -> None:
        """How far the samples of a block scatter."""
        if block.count > 1:
            bounded = min(block.scatter, self._assumed.largest_scatter * self._scatter)
            self._scatter += (bounded - self._scatter) / self._assumed.scatter_blocks

    @property
    def random(self) -> bool:
        """Whether there is a force, and the accelerometer shows its share of it."""
        excess, assumed = self._scatter - self._sample_m2, self._assumed
        shown = assumed.shown_share * self.intensity / self._per_scatter
        return self.intensity > 0.0 and excess > max(assumed.shown_noise * self._sample_m2, shown)

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
