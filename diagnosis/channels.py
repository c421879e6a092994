"""Which channels a recording has for a diagnosis, and why each of the others is left out.

No recording need hold any one of them: this is the one place that decides, and everybody else asks for a channel by
name and is told None (diagnosis.fit.Fit.channel) or finds it missing (diagnosis.world.World.channels).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.frame_clock import FrameClock
from diagnosis.measured import Measured

Array = NDArray[np.float64]

FAST_CHANNELS = ("acceleration", "joint_position", "joint_velocity", "deflection")
FRAME_CHANNELS = ("displacement", "arrival")
JOINT_CHANNELS = ("joint_position", "joint_velocity")
ARM_CHANNELS = ("acceleration", "deflection", "displacement")
MIN_FAST_VALUES, MIN_FRAMES = 51, 21  # fewer tell no level of noise beside a handful of fitted quantities


@dataclass(frozen=True)
class PresentChannels:
    """values: samples of each channel that is used, NaN where unmeasured. left_out: why each other one that was
    recorded is not, in words."""

    values: dict[str, Array]
    left_out: dict[str, str]


def present_channels(measured: Measured, clock: FrameClock) -> PresentChannels:
    """The channels with enough values, those of the arm only where they vary: a sensor that never changes is dead, and
    its residual has no level. A joint that stands still is none the less known."""
    frames = measured.frames
    asked: list[tuple[str, Array, int]] = [
        *((name, measured.channel(name), MIN_FAST_VALUES) for name in FAST_CHANNELS),
        ("displacement", frames.displacement_px, MIN_FRAMES),
    ]
    if not clock.arrival:
        asked.append(("arrival", frames.received_s, MIN_FRAMES))
    values: dict[str, Array] = {}
    left_out: dict[str, str] = {}
    for name, samples, fewest in asked:
        reason = _why_not(name, samples, fewest)
        if reason is None and measured.imposed and name in JOINT_CHANNELS:
            reason = "drives the simulation, as no joint_velocity_command_rad_s was recorded"
        if reason is None:
            values[name] = samples
        elif reason:
            left_out[name] = reason
    return PresentChannels(values, left_out)


def _why_not(name: str, samples: Array, fewest: int) -> str | None:
    """None: it is used. Empty: it was not recorded."""
    known = samples[np.isfinite(samples)]
    if not len(known):
        return ""
    if len(known) < fewest:
        return f"{len(known)} values, where at least {fewest} are needed"
    if name in ARM_CHANNELS and float(np.ptp(known)) == 0.0:
        return f"each of its {len(known)} values is {known[0]:g}"
    return None


__all__ = ["ARM_CHANNELS", "FAST_CHANNELS", "FRAME_CHANNELS", "PresentChannels", "present_channels"]
