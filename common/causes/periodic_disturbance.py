"""A periodic force on the arm."""

import numpy as np

from stillarm.common.causes.declaration import PHASE, Cause, frequency, size


def law(
    t: float,
    theta: float,
    omega: float,
    q: float,
    v: float,
    w: float,
    frequency_hz: float,
    amplitude_m_s2: float,
    phase_rad: float,
) -> float:
    """Acceleration of the first mode, m/s^2."""
    wave: float = amplitude_m_s2 * np.sin(2.0 * np.pi * frequency_hz * t + phase_rad)
    return wave


CAUSE = Cause(
    "periodic_disturbance",
    "arm",
    name="a periodic force on the arm",
    sees="the arm never comes to rest but goes on swinging at a foreign frequency, as beside a pump",
    note="Image and accelerometer both show it.",
    equation="q_1'' = ... + amplitude sin(2 pi frequency t + phase)",
    parameters=(
        frequency(1.0, 6.0),
        size("amplitude_m_s2", "m/s^2", 1000.0, 0.1, 0.5),
        PHASE,
    ),
    provoke="leave the arm alone for half a minute.",
    acts="force",
    foreign=True,
    law=law,
    repeatable=True,
)
