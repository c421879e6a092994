"""A whole case from a seed: a cause, a rig on which it may be hidden, a size that shows as clearly as drawn."""

from dataclasses import dataclass, replace

import numpy as np

from tests.hidden_world.driven.departure import Plain
from tests.hidden_world.driven.draw import draw_rig
from tests.hidden_world.driven.effects import CAUSES, SENSOR_CAUSES, Scales, absolute
from tests.hidden_world.driven.recording import Recording, record
from tests.hidden_world.driven.rig import Effect, Rig, log_uniform, luck

FAINTEST, LARGEST = 3.0, 100.0
"""Between these many deviations of its clearest channel's noise an effect shows."""
_CLOSE_ENOUGH = 1.15
_MOST_OF_TEETH = 0.2  # of what play shows, that teeth which give way show without play
_TRIALS = 9
_ATTEMPTS = 10


@dataclass(frozen=True)
class Case:
    """What is written. effect: its size in its own unit; None where nothing is hidden.

    relative: its size as effects.py draws it. seen: by channel, rms of what the effect changes over the noise, after a
    refit of the rig's own parameters; raw: the same without one. shows: the largest, of raw where the cause stands
    against a stated rig, of seen otherwise.
    """

    rig: Rig
    scales: Scales
    effect: Effect | None
    relative: float
    recording: Recording
    seen: dict[str, float]
    raw: dict[str, float]
    shows: float


def make(seed: int, cause: str, longest_s: float = 60.0) -> Case:
    """cause: one of CAUSES, or none. Raises RuntimeError where no rig lets the cause show between the bounds."""
    for attempt in range(_ATTEMPTS):
        rig, scales = draw_rig(seed, cause, attempt, longest_s)
        if cause == "none":
            return Case(rig, scales, None, 0.0, record(rig), {}, {}, 0.0)
        if CAUSES[cause].stated:
            rig = replace(rig, stated=True)
        if cause == "sensor_scale" and not tells_scales(rig):
            continue
        case = _sized(rig, scales, _effect(rig, cause, attempt), attempt)
        if case is not None:
            return case
    raise RuntimeError(f"case {seed}: {cause} does not show between {FAINTEST:g} and {LARGEST:g} deviations")


def tells_scales(rig: Rig) -> bool:
    """Whether a sensor's scale can be told: by a command of known unit, or by another sensor of one. Else the command's
    unknown unit makes up for it."""
    known = [one for one in rig.channels if not one.unit.endswith("_v")]
    return rig.drive.log_unit == "si" or len(known) > 1


def _effect(rig: Rig, cause: str, attempt: int) -> Effect:
    """Its form, side, channel; the size is found later."""
    chance = luck(rig.seed, 11, attempt)
    channel = ""
    if cause == "encoder_quantisation":
        channel = next(c.kind for c in rig.channels if "position" in c.kind)
    elif cause == "sensor_scale":
        channel = str(chance.choice([c.kind for c in rig.channels if not c.unit.endswith("_v")]))
    elif cause in SENSOR_CAUSES:
        channel = str(chance.choice([c.kind for c in rig.channels]))
    details = (float(chance.random()), float(chance.random()))
    sign = float(chance.choice([-1.0, 1.0]))
    return Effect(cause, str(chance.choice(CAUSES[cause].forms)), 0.0, sign, channel, details)


def _sized(rig: Rig, scales: Scales, effect: Effect, attempt: int) -> Case | None:
    """The case at a size at which the effect shows as drawn; None where the bounds of its size do not reach that."""
    kind, geared = CAUSES[effect.cause], effect.cause == "gear_backlash"
    wanted = log_uniform(luck(rig.seed, 12, attempt), 1.2 * FAINTEST, LARGEST / 1.2)
    plain = Plain(rig)
    low, high = np.log(kind.low), np.log(kind.high)
    for _ in range(_TRIALS):
        relative = float(np.exp(0.5 * (low + high)))
        tried = absolute(replace(effect, size=relative), scales)
        changed = record(rig, tried, noise=False)
        seen, raw = plain.departures(changed, True), plain.departures(changed, False)
        shows = max((raw if kind.stated else seen).values())
        if wanted / _CLOSE_ENOUGH < shows < wanted * _CLOSE_ENOUGH:
            break
        low, high = (np.log(relative), high) if shows < wanted else (low, np.log(relative))
    if not FAINTEST <= shows <= LARGEST:
        return None
    if geared and _teeth_alone(plain) > _MOST_OF_TEETH * shows:
        return None
    return Case(rig, scales, tried, relative, record(rig, tried), seen, raw, shows)


def _teeth_alone(plain: Plain) -> float:
    """Deviations that the gear's stiffness shows without play."""
    return max(plain.departures(record(plain.rig, noise=False, geared=True), True).values())
