"""The causes in the camera's timing: skew, losses, bursts, drift, stale frames, a stepping camera clock."""

from collections import deque
from collections.abc import Callable
from itertools import compress
from math import prod

import numpy as np

from stillarm.common.causes import CAUSES
from stillarm.common.causes.declaration import Acts
from stillarm.common.files.effects import Values, acting, laws_at
from stillarm.common.files.model import Model
from stillarm.simulation.arm.effect_clock import EffectClock

_LOSS_STREAM, _BURST_STREAM = 0x1057F, 0xB0257
_MOST_FRAMES = 64  # that a stale buffer holds: two laws of the catalogue's most


class FrameTimingEffects:
    """Changes a frame's instants, frame by frame in their order. It does not use the timing's own random numbers, so
    that an effect of size zero changes nothing."""

    def __init__(self, model: Model, seed: int, clock: EffectClock) -> None:
        """As the model's effects name them; losses and bursts come from the seed. clock: that of the exposures."""
        self._clock = clock
        self.period_ratio = prod(law() for law in laws_at(model, "period"))
        """Frame period over the declared one."""
        self._delays = laws_at(model, "delay")
        self._losing = laws_at(model, "loss")
        self._losses = np.random.default_rng((seed, _LOSS_STREAM))
        self._bursts = [
            _Bursts(law, values["rate_hz"], np.random.default_rng((seed, _BURST_STREAM)))
            for law, values in zip(laws_at(model, "burst"), _values_at(model, "burst"), strict=True)
        ]
        self._ages = laws_at(model, "age")
        self._starts: deque[float] = deque(maxlen=_MOST_FRAMES + 1)
        of_camera = [values["clock"] == "camera" for values in _values_at(model, "clock")]
        self._steps = list(compress(laws_at(model, "clock"), of_camera))

    def further_delay_s(self, mid_s: float, handover_s: float) -> float:
        """Addition to the delay of a frame that would be handed over at `handover_s`, s."""
        since_start_s = self._clock.at(mid_s)
        delay = sum(law(since_start_s) for law in self._delays)
        return float(delay + sum(bursts.delay_s(handover_s) for bursts in self._bursts))

    def is_lost(self) -> bool:
        """Whether the next frame is lost. Once for each frame."""
        # each draws, whatever the others say
        lost = [law(float(self._losses.random())) for law in self._losing]
        return any(lost)

    def shown_start_s(self, start_s: float) -> float:
        """Start of the exposure whose image is handed over as the one that starts at `start_s`. Once for each."""
        self._starts.append(start_s)
        age = sum(law(self._clock.at(start_s)) for law in self._ages)
        return self._starts[-1 - min(age, len(self._starts) - 1)]

    def stamp_step_s(self, mid_s: float) -> float:
        """What the camera's own clock has jumped by, at mid-exposure."""
        time_s = self._clock.at(mid_s)
        return float(sum(law(time_s) for law in self._steps))


def _values_at(model: Model, acts: Acts) -> list[Values]:
    """Parameters of the effects whose laws `laws_at` gives, in its order."""
    return [values for identifier, values in acting(model) if CAUSES[identifier].acts == acts]


class _Bursts:
    """Spells of delay that begin at Poisson instants; one that begins while another lasts prolongs it."""

    def __init__(self, law: Callable[[float], float], rate_hz: float, generator: np.random.Generator) -> None:
        """law: s since a burst began -> delay, s."""
        self._law = law
        self._rate_hz = rate_hz
        self._generator = generator
        self._next_s: float | None = None
        self._began_s = float("-inf")

    def delay_s(self, time_s: float) -> float:
        """At an instant; to be asked in (nearly) increasing order."""
        if self._next_s is None:
            self._next_s = time_s + self._gap()
        while self._next_s <= time_s:
            self._began_s = self._next_s
            self._next_s += self._gap()
        return self._law(time_s - self._began_s)

    def _gap(self) -> float:
        return float(self._generator.exponential(1.0 / self._rate_hz))
