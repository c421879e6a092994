"""A small motion of the joint with which the camera can be dated when the accelerometer has died.

The image shows the joint's known motion with the capture delay. The motion is a slow sine, away from all modes, which
fades in and out over whole seconds so that it excites none of them. The command is the difference of two positions, so
that the joint is never further than the amplitude from its position before.
"""

from math import cos, pi, sin
from typing import NamedTuple

from stillarm.common.files.configuration import Dither
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError

_APART = 0.3  # of a mode's frequency


class DitherState(NamedTuple):
    """phase_rad: of the sine; weight: 0 (still) to 1; position_rad: present displacement of the joint."""

    phase_rad: float = 0.0
    weight: float = 0.0
    position_rad: float = 0.0


STILL = DitherState()


def check_dither(settings: Dither, model: Model) -> None:
    """Raise UserError for a frequency near a mode's, or for a velocity beyond the drive's."""
    if not settings.enabled:
        return
    for mode in model.arm.modes:
        if abs(settings.frequency_hz - mode.frequency_hz) < _APART * mode.frequency_hz:
            raise UserError(
                f"controller.dither.frequency_hz = {settings.frequency_hz:g}: within {_APART:.0%} of the mode at "
                f"{mode.frequency_hz:g} Hz, which it would excite; choose one further away"
            )
    most = highest_velocity_rad_s(settings)
    if most > model.drive.max_velocity_rad_s:
        raise UserError(
            f"controller.dither.amplitude_rad = {settings.amplitude_rad:g}: needs {most:.3g} rad/s, the drive allows "
            f"{model.drive.max_velocity_rad_s:g}; choose a smaller amplitude or frequency"
        )


def highest_velocity_rad_s(settings: Dither) -> float:
    """Upper bound of the commands: that of the full sine, plus that of its fading."""
    return settings.amplitude_rad * (2.0 * pi * settings.frequency_hz + 0.5 * pi / settings.fade_s)


def dither_on(
    state: DitherState, wanted: bool, elapsed_s: float, settings: Dither
) -> tuple[DitherState, float]:
    """Advance by one cycle. Returns the new state, and the joint velocity of this cycle, rad/s.

    It begins where the sine is zero; its amplitude rises and falls as a raised cosine over `fade_s`.
    """
    if state.weight <= 0.0 and not wanted:
        return STILL, 0.0
    rise = elapsed_s / settings.fade_s
    weight = min(1.0, state.weight + rise) if wanted else max(0.0, state.weight - rise)
    phase = (state.phase_rad + 2.0 * pi * settings.frequency_hz * elapsed_s) % (2.0 * pi)
    share = 0.5 * (1.0 - cos(pi * weight))
    position = settings.amplitude_rad * share * sin(phase)
    return DitherState(phase, weight, position), (position - state.position_rad) / elapsed_s
