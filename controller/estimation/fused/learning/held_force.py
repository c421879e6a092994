"""A force at the tip that lasts: a hand that pulls, a payload that is picked up, contact with a wall.

Implements Eqs. 54, 55, 56, 57, 59 of docs/fused.md.

Such a force deflects the tip statically by f = F / (m w^2), and the mode vibrates about f: q = Re(Z exp(j w t)) + f.
The force is a random walk (an augmented unknown input; Gillijns and De Moor, Automatica 43, 2007). Deflection and rate
do not jump with the force, so that a step df also moves the phasor by -df exp(-j w t). A release is such a step: f
returns to zero, and the arm rings with the amplitude that it had been pulled aside by.

Images show f and the accelerometer does not. The state is therefore not used (zero, with zero variance) until images
leave their gate and the accelerometer has seen no impact.
"""

from collections import deque
from math import exp, sqrt

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class SlowPull:
    """Detects a force that begins too slowly for any one image to leave its gate, by innovations that keep their sign.

    Their mean fades over half a period of the vibration, so that what vibrates averages out.
    """

    def __init__(self, half_period_frames: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """No innovation seen."""
        self._assumed = assumed.held_force
        self._share = 1.0 / max(half_period_frames, self._assumed.fewest_frames)
        self._significant = self._assumed.pull_stds * sqrt(self._share / (2.0 - self._share))
        self._zeros: deque[tuple[float, float]] = deque(
            maxlen=max(2, round(self._assumed.zero_periods * half_period_frames))
        )
        self.restart()

    def restart(self) -> None:
        """What has been seen has been taken care of."""
        self._mean = 0.0

    def followed_m(self) -> float:
        """How far the image's zero has followed the pull since it began, m; 0 if the zero was not known well enough
        then to say so."""
        if not self._zeros:
            return 0.0
        moved, variance = self._zeros[-1][0] - self._zeros[0][0], self._zeros[0][1]
        return moved if moved * moved > self._assumed.followed * variance else 0.0

    def see(self, innovation: float, zero_m: float, variance: float) -> bool:
        """Process an image's innovation in standard deviations, and the image's zero, m, with its variance, m^2;
        whether there is a pull."""
        self._zeros.append((zero_m, variance))
        bounded = min(max(innovation, -self._assumed.largest_stds), self._assumed.largest_stds)
        self._mean += self._share * (bounded - self._mean)
        return abs(self._mean) > self._significant


class HeldForce:
    """Whether a force is held, and how fast it changes.

    active: whether the state is in use. walk: growth of the variance of f, m^2/s.
    """

    def __init__(
        self, modes: int, noise_m2: float, period_s: float, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """modes: of the arm; noise_m2: variance of an image, m^2; period_s: of the first mode."""
        self._assumed = assumed.held_force
        self._reversals: deque[float] = deque(maxlen=self._assumed.reversals)
        self._reversing_s = 0.5 * (self._assumed.reversals + 1.0) * period_s
        self._sign = 0.0
        self._not_before_s = self._begun_s = self._short_s = float("-inf")
        self._none = (0.0,) * modes
        self._rest = self._assumed.rest_share * noise_m2
        self._past: deque[tuple[float, float]] = deque()
        self.active = False
        self.walk = 0.0
        self._none_since_s = float("inf")
        self._expected = 0.0  # variance of a force as large as what has been seen of it, m^2

    @property
    def moves(self) -> bool:
        """Whether there is a force that changes."""
        return self.active and self.walk > self._assumed.at_rest * self._rest

    def may_begin(self, time_s: float) -> bool:
        """Whether one may begin, after what has turned out to be none."""
        return self.active or time_s >= self._not_before_s

    def by_wrong_dates_m(self, amplitude_m: float) -> float:
        """How far wrong dates alone may move the images of a vibration, m."""
        return self._assumed.by_wrong_dates * amplitude_m

    def begin(self, time_s: float, size_m: float) -> None:
        """Images left their gate by about size_m: a force may have begun, changed, or ended."""
        if not self.active:
            self._begun_s = time_s
        self.active = True
        self.walk = max(self.walk, size_m * size_m / self._assumed.onset_s)
        self._expected = max(self._expected, size_m * size_m)
        self._past.clear()
        self._none_since_s = time_s

    def step(self, size_m: float) -> None:
        """The accelerometer has seen the force change at once by size_m: the change itself is known."""
        self.active = True
        self._expected = max(self._expected, size_m * size_m)
        self.walk = max(self.walk, self._rest)
        self._past.clear()

    def rests(self, value_m: float, time_s: float) -> None:
        """Images of a whole period show a force of value_m that does not change."""
        self.active = True
        self.walk = self._rest
        self._expected = max(self._expected, value_m * value_m)
        self._past.clear()
        self._reversals.clear()
        self._none_since_s = time_s

    def during(self, start_s: float, end_s: float, share: float = 1.0) -> Jump | None:
        """What the force may have done between two times. share: probability that there is one."""
        if not self.active or share <= 0.0:
            return None
        size = sqrt(share * self.walk * (end_s - start_s))
        return Jump(0.5 * (start_s + end_s), self._none, self._none, size)

    def see(self, time_s: float, value_m: float, variance: float) -> bool:
        """After an image: the force's static deflection and its variance, m^2. Returns whether there is none left."""
        past = self._past
        past.append((time_s, value_m))
        while time_s - past[0][0] > self._assumed.span_s and len(past) > 2:
            past.popleft()
        span = time_s - past[0][0]
        if span > 0.5 * self._assumed.span_s:
            step = value_m - past[0][1]
            self.walk = max(step * step / span, self._rest)
        if value_m * value_m > self._assumed.gate_stds * self._assumed.gate_stds * variance:
            self._none_since_s = time_s
            if value_m * self._sign < 0.0:
                self._reversals.append(time_s)
            self._sign = value_m
        return time_s - self._none_since_s > self._assumed.none_for_s or self._unlikely(value_m, variance)

    def _unlikely(self, value_m: float, variance: float) -> bool:
        """Odds of no force against one of the size expected, by how near to zero it is known to be (Savage and Dickey:
        J. M. Dickey, Annals of Mathematical Statistics 42, 1971)."""
        if self.moves or variance <= 0.0:
            return False
        return (
            sqrt(self._expected / variance) * exp(-0.5 * value_m * value_m / variance)
            > self._assumed.odds_of_none
        )

    def oscillates(self, time_s: float) -> bool:
        """Whether the force has reversed with every half period: no force lasts that does so, the arm has changed."""
        reversals = self._reversals
        if len(reversals) < self._assumed.reversals or reversals[-1] - reversals[0] > self._reversing_s:
            return False
        self._not_before_s = time_s + self._assumed.not_again_s
        return True

    def end(self, time_s: float, *, explained: bool = False) -> None:
        """No force is left. Two short forces in a row count as a steady random force, which looks like that. explained:
        a free vibration explains the images since, as after a push.
        """
        if self.active and not explained and time_s - self._begun_s < self._assumed.short_s:
            if time_s - self._short_s < self._assumed.short_again_s:
                self._not_before_s = time_s + self._assumed.not_again_s
            self._short_s = time_s
        self._reversals.clear()
        self._sign = 0.0
        self.active = False
        self.walk = self._expected = 0.0
        self._past.clear()
