"""Mains hum in the accelerometer."""

import numpy as np

from stillarm.common.causes.declaration import PHASE, Cause, frequency, size


def law(t: float, tip_angle: float, frequency_hz: float, amplitude_m_s2: float, phase_rad: float) -> float:
    """Added to the reading, m/s^2."""
    wave: float = amplitude_m_s2 * np.sin(2.0 * np.pi * frequency_hz * t + phase_rad)
    return wave


CAUSE = Cause(
    "mains_hum",
    "accelerometer",
    name="mains hum in the accelerometer",
    sees="a steady tone in the acceleration that no image shows",
    equation="a = ... + amplitude sin(2 pi frequency t + phase)",
    parameters=(
        frequency(45.0, 65.0),
        size("amplitude_m_s2", "m/s^2", 1000.0, 0.2, 1.0),
        PHASE,
    ),
    provoke="rest; the accelerometer's spectrum shows a line.",
    acts="reading",
    law=law,
    repeatable=True,
)
