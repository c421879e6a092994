"""Which channels a recording has for a diagnosis, and why each of the others is left out.

No recording need hold any one of them: this is the one place that decides, and everybody else asks for a channel by
name and is told None (stillarm.diagnosis.fitting.fitted.Fit.channel) or finds it missing
(stillarm.diagnosis.physics.world.World.channels).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.frame_clock import FrameClock
from stillarm.diagnosis.data.measured import Measured

Array = NDArray[np.float64]
FAST_CHANNELS = ("acceleration", "joint_position", "joint_velocity", "deflection")
FRAME_CHANNELS = ("displacement", "arrival")
JOINT_CHANNELS = ("joint_position", "joint_velocity")
ARM_CHANNELS = ("acceleration", "deflection", "displacement")
BEND_CHANNELS = ("deflection", "displacement")
"""Those that show slow bends too, to which an accelerometer is blind."""
MIN_FAST_VALUES, MIN_FRAMES = 51, 21  # fewer tell no level of noise beside a handful of fitted quantities


@dataclass(frozen=True)
class PresentChannels:
    """values: samples of each channel that is used, NaN where unmeasured. left_out: why each other one that was
    recorded is not, in words."""

    values: dict[str, Array]
    left_out: dict[str, str]


def present_channels(measured: Measured, clock: FrameClock) -> PresentChannels:
    """The channels with enough values. A joint that was measured where no command was is no channel: it is an input."""
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
        reason = _why_not(samples, fewest)
        if reason is None and measured.imposed and name in JOINT_CHANNELS:
            reason = "drives the simulation, as no joint_velocity_command_rad_s was recorded"
        if reason is None:
            values[name] = samples
        elif reason:
            left_out[name] = reason
    return PresentChannels(values, left_out)


def without_dead_sensors(measured: Measured) -> tuple[Measured, dict[str, str]]:
    """The same data without the arm's channels that never change, and why, by channel: such a sensor is dead, and its
    residual has no level. A joint that stands still is none the less known."""
    frames = measured.frames
    seen = {
        "acceleration": measured.acceleration,
        "deflection": measured.deflection,
        "displacement": frames.displacement_px,
    }
    dead: dict[str, str] = {}
    for name in ARM_CHANNELS:
        known = seen[name][np.isfinite(seen[name])]
        if len(known) and float(np.ptp(known)) == 0.0:
            dead[name] = f"each of its {len(known)} values is {known[0]:g}"
            seen[name] = np.full(len(seen[name]), np.nan)
    if not dead:
        return measured, dead
    frames = replace(frames, displacement_px=seen["displacement"])
    alive = replace(measured, acceleration=seen["acceleration"], deflection=seen["deflection"], frames=frames)
    return alive, dead


def _why_not(samples: Array, fewest: int) -> str | None:
    """None: it is used. Empty: it was not recorded."""
    known = samples[np.isfinite(samples)]
    if not len(known):
        return ""
    if len(known) < fewest:
        return f"{len(known)} values, where at least {fewest} are needed"
    return None
