"""The causes that sit in the camera's timing: skew, losses, bursts, drift, stale frames, a stepping camera clock."""

from collections import deque

import numpy as np

from common.effects import Values, effect_of, effects_of
from common.model import Model
from simulation.effect_clock import EffectClock

_LOSS_STREAM, _BURST_STREAM = 0x1057F, 0xB0257


class FrameTimingEffects:
    """What becomes of a frame's instants, frame by frame in their order; the timing's own random numbers are left
    alone, so that an effect of size zero changes nothing."""

    def __init__(self, model: Model, seed: int, clock: EffectClock) -> None:
        """As the model's effects name them; losses and bursts come from the seed. clock: that of the exposures."""
        self._clock = clock
        skew, drift = effect_of(model, "camera_clock_skew"), effect_of(model, "delay_drift")
        drops, bursts = effect_of(model, "frame_drops"), effect_of(model, "delay_bursts")
        stale = effect_of(model, "stale_frame_buffer")
        self.period_ratio = 1.0 + 1e-6 * (skew["skew_ppm"] if skew else 0.0)
        """Frame period over the declared one."""
        self._drift_s_per_s = drift["rate_s_per_s"] if drift else 0.0
        self._lost_share = drops["fraction"] if drops else 0.0
        self._losses = np.random.default_rng((seed, _LOSS_STREAM))
        self._bursts = _Bursts(bursts, np.random.default_rng((seed, _BURST_STREAM))) if bursts else None
        self._stale_from_s = stale["onset_s"] if stale else float("inf")
        self._stale_frames = int(stale["frames"]) if stale else 0
        self._starts: deque[float] = deque(maxlen=self._stale_frames + 1)
        self._steps = [
            (step["onset_s"], step["step_s"])
            for step in effects_of(model, "clock_step")
            if step["clock"] == "camera"
        ]

    def further_delay_s(self, mid_s: float, handover_s: float) -> float:
        """What is added to the delay of a frame that would be handed over at `handover_s`."""
        delay = self._drift_s_per_s * self._clock.at(mid_s)
        if self._bursts is not None:
            delay += self._bursts.delay_s(handover_s)
        return delay

    def is_lost(self) -> bool:
        """Whether the next frame is lost. Once for each frame."""
        return self._lost_share > 0.0 and float(self._losses.random()) < self._lost_share

    def shown_start_s(self, start_s: float) -> float:
        """Start of the exposure whose image is handed over as the one that starts at `start_s`. Once for each."""
        self._starts.append(start_s)
        return self._starts[0] if self._clock.at(start_s) >= self._stale_from_s else start_s

    def stamp_step_s(self, mid_s: float) -> float:
        """What the camera's own clock has jumped by, at mid-exposure."""
        time_s = self._clock.at(mid_s)
        return float(sum(step_s for onset_s, step_s in self._steps if time_s >= onset_s))


class _Bursts:
    """Spells of delay that begin at Poisson instants; one that begins while another lasts prolongs it."""

    def __init__(self, values: Values, generator: np.random.Generator) -> None:
        self._rate_hz: float = values["rate_hz"]
        self._duration_s: float = values["duration_s"]
        self._delay_s: float = values["delay_s"]
        self._generator = generator
        self._next_s: float | None = None
        self._until_s = float("-inf")

    def delay_s(self, time_s: float) -> float:
        """At an instant; to be asked in (nearly) increasing order."""
        if self._rate_hz == 0.0:
            return 0.0
        if self._next_s is None:
            self._next_s = time_s + self._gap()
        while self._next_s <= time_s:
            self._until_s = self._next_s + self._duration_s
            self._next_s += self._gap()
        return self._delay_s if time_s < self._until_s else 0.0

    def _gap(self) -> float:
        return float(self._generator.exponential(1.0 / self._rate_hz))
