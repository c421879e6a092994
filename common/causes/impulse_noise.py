"""Spikes in the acceleration."""

from stillarm.common.causes.declaration import Cause, size


def law(sign: float, rate_hz: float, amplitude_m_s2: float) -> float:
    """Added to one sample, m/s^2."""
    return sign * amplitude_m_s2


CAUSE = Cause(
    "impulse_noise",
    "accelerometer",
    name="spikes in the acceleration",
    sees=(
        "single samples of the acceleration are far off, at no particular time: a loose contact, a "
        "disturbed bus"
    ),
    equation="at Poisson instants one sample of +-amplitude, of random sign, is added",
    parameters=(
        size("rate_hz", "1/s", 1000.0, 0.2, 3.0),
        size("amplitude_m_s2", "m/s^2", 1e6, 4.0, 15.0),
    ),
    provoke="rest, for a minute.",
    acts="impulse",
    law=law,
    repeatable=True,
)
