"""What laboratories drive a joint with: shapes of unit size, one value a sample."""

import numpy as np

from tests.hidden_world.driven.rig import Values

OPEN = ("multisine", "chirp", "prbs", "steps", "bang_bang", "random_phase")
CLOSED = ("steps", "multisine", "ramps")


def shape(kind: str, rows: int, rate_hz: float, top_hz: float, chance: np.random.Generator) -> Values:
    """Values within -1 to 1 (about), with nothing above top_hz where the kind allows that."""
    t = np.arange(rows) / rate_hz
    made = {
        "multisine": _multisine,
        "random_phase": _random_phase,
        "chirp": _chirp,
        "prbs": _prbs,
        "steps": _steps,
        "bang_bang": _bang_bang,
        "ramps": _ramps,
    }[kind](t, top_hz, chance)
    return np.asarray(made, dtype=float)


def _multisine(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    """A few sines, none below two periods in the record."""
    tones = np.exp(chance.uniform(np.log(2.0 / t[-1]), np.log(top_hz), int(chance.integers(5, 16))))
    out = sum(
        np.sin(2.0 * np.pi * f * t + p)
        for f, p in zip(tones, chance.uniform(0.0, 2.0 * np.pi, len(tones)), strict=True)
    )
    return np.asarray(out / np.max(np.abs(out)))


def _random_phase(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    """Every line of the record's own spectrum up to top_hz, alike in size (Pintelon and Schoukens 2012, ch. 2)."""
    lines = np.arange(len(t) // 2 + 1) / (len(t) * (t[1] - t[0]))
    spectrum = np.where((lines > 2.0 / t[-1]) & (lines < top_hz), 1.0, 0.0) + 0j
    spectrum *= np.exp(1j * chance.uniform(0.0, 2.0 * np.pi, len(lines)))
    out = np.fft.irfft(spectrum, len(t))
    return np.asarray(out / np.max(np.abs(out)))


def _chirp(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    """A logarithmic sweep, up or down."""
    low = max(3.0 / t[-1], 0.1)
    growth = np.log(top_hz / low) / t[-1]
    out = np.sin(2.0 * np.pi * low / growth * np.expm1(growth * t) + chance.uniform(0.0, 6.0))
    return np.asarray(out if chance.random() < 0.7 else out[::-1])


def _prbs(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    """A random binary sequence with a clock of 2.5 top_hz."""
    clock = np.floor(t * min(2.5 * top_hz, 1.0 / (t[1] - t[0]))).astype(int)
    return np.asarray(np.where(chance.random(clock[-1] + 1) < 0.5, -1.0, 1.0)[clock])


def _levels(t: Values, chance: np.random.Generator) -> tuple[Values, Values]:
    """When a level begins, and the levels: each second one returns towards zero."""
    begins = np.cumsum(chance.uniform(0.4, 2.5, int(t[-1] / 0.4) + 2))
    begins = np.concatenate([[0.0], begins[begins < t[-1]]])
    return begins, chance.uniform(-1.0, 1.0, len(begins)) * np.where(begins > 0.0, 1.0, 0.0)


def _steps(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    begins, levels = _levels(t, chance)
    return np.asarray(levels[np.searchsorted(begins, t, side="right") - 1])


def _ramps(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    begins, levels = _levels(t, chance)
    return np.interp(t, begins, levels)


def _bang_bang(t: Values, top_hz: float, chance: np.random.Generator) -> Values:
    """Full one way, as long the other way, then nothing for a while."""
    out, at = np.zeros(len(t)), 0.0
    while at < t[-1]:
        half, rest = chance.uniform(0.1, 0.8), chance.uniform(0.1, 1.0)
        sign = chance.choice([-1.0, 1.0])
        out[(t >= at) & (t < at + half)] = sign
        out[(t >= at + half) & (t < at + 2.0 * half)] = -sign
        at += 2.0 * half + rest
    return out
