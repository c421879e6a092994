"""Rows of the third table in which a method starts or restarts, with separate figures for that time."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import nan

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.closed_loop import Course, to_and_fro
from stillarm.benchmarks.estimators.trial import Mask, Said, mean_square
from stillarm.benchmarks.estimators.world.condition import Condition, Span
from stillarm.benchmarks.estimators.world.excitation import (
    FIRST_S,
    pulled_slowly_at,
    pushed_again,
    released_again,
    struck_once,
)
from stillarm.benchmarks.estimators.world.generator import Data
from stillarm.benchmarks.estimators.world.regimes import AFTER_IMPACT_S

Values = NDArray[np.float64]
REGIMES_STARTED = ("freerun drift", "triggered drift", "live")
_AT_S = 15.0  # time of an event in mid-run
_BEGINS_S = 2.0  # duration of a start
_AFTER_GAP_S = 10.0
_RESTART_S = 2.0  # from the old supervisor's last image to the new one's first
_NOMINAL_DELAY_S = 0.074
_JOG_EVERY_S, _JOG_S, _JOG_RAD_S = 4.0, 0.3, 0.03  # excite 1.2 of the nominal amplitude

FIGURES = (
    "error_mean_during", "error_max_during", "delay_normalised_error_squared_during",
    "deflection_normalised_error_squared_during", "unanswered_during",
)  # fmt: skip


@dataclass(frozen=True)
class During:
    """Figures of the start, as fractions of the nominal amplitude. Unanswered cycles count as a prediction of zero."""

    error_mean_during: float
    error_max_during: float
    delay_normalised_error_squared_during: float
    deflection_normalised_error_squared_during: float
    unanswered_during: float


def during_of(said: Said, cycles: Mask, frames: Mask, nominal_m: float) -> During:
    """Judge those cycles and frames."""
    known = np.isfinite(said.predicted_m[cycles])
    error = np.where(known, said.predicted_m[cycles], 0.0) - said.deflection_m[cycles]
    with np.errstate(divide="ignore", invalid="ignore"):
        normalised = error[known] / said.predicted_std_m[cycles][known]
        delay = said.delay_error_s[frames] / said.delay_std_s[frames]
    relative = np.abs(error) / nominal_m
    return During(
        float(relative.mean()),
        float(relative.max()),
        mean_square(delay),
        mean_square(normalised),
        float(1.0 - known.mean()),
    )


def _from_the_first(data: Data) -> list[Span]:
    """The span after the first motion of an arm at rest."""
    begun = float(data.motion.start_s[1])
    return [(begun, begun + _BEGINS_S)]


def _forced(data: Data) -> list[Span]:
    return [(float(begin), float(end)) for begin, end in data.motion.forced_s]


def _without_images(lasts_s: float, restarted: bool = False) -> Condition:
    """No image is exposed for a time. restarted: the images after it come from a new supervisor, with another zero."""

    def lose(data: Data, random: np.random.Generator) -> Data:
        exposed = data.frames.exposed_s
        left = data.with_frames_lost((exposed >= _AT_S) & (exposed < _AT_S + lasts_s))
        if not restarted:
            return left
        new = left.frames.exposed_s >= _AT_S
        first = int(np.argmax(new))
        number = np.where(new, left.frames.number - left.frames.number[first], left.frames.number)
        seen = np.where(new, left.seen_m - left.seen_m[first], left.seen_m)
        return replace(left, frames=replace(left.frames, number=number), seen_m=seen)

    begins = _AT_S + _NOMINAL_DELAY_S
    ends = begins + lasts_s
    return Condition(
        duration_s=ends + _AFTER_GAP_S,
        from_s=ends + (AFTER_IMPACT_S if restarted else 0.0),  # a restarted method needs images first
        change_data=lose,
        during=lambda data: [(begins, ends)],
    )


def _never_alive(data: Data, random: np.random.Generator) -> Data:
    return replace(data, acceleration_m_s2=np.full(len(data.acceleration_m_s2), nan))


def _at_once(data: Data) -> list[Span]:
    return [(0.0, _BEGINS_S)]


OPEN_STARTS: dict[str, Condition] = {
    "start while swinging": Condition(duration_s=12.0, during=_at_once),
    "first swing from rest": Condition(duration_s=9.0, excite=struck_once, during=_from_the_first),
    "accelerometer dead from the start": Condition(change_data=_never_alive, during=_at_once),
    "release": Condition(excite=released_again, during=_forced),
    "push by hand": Condition(duration_s=20.0, excite=pushed_again, during=_forced),
    "slow pull in mid-run": Condition(
        duration_s=26.0, from_s=_AT_S, excite=pulled_slowly_at(_AT_S), during=_forced
    ),
    "images gap 0.3 s": _without_images(0.3),
    "images gap 1 s": _without_images(1.0),
    "images gap 3 s": _without_images(3.0),
    "images gap 10 s": _without_images(10.0),
    "supervisor restarted": _without_images(_RESTART_S, restarted=True),
}


CLOSED_STARTS: dict[str, tuple[Course, Callable[[], list[Span]]]] = {
    "first motion of the joint": (
        Course(16.0, {}, reference=to_and_fro(FIRST_S, _JOG_EVERY_S, _JOG_S, _JOG_RAD_S)),
        lambda: [(FIRST_S, FIRST_S + _BEGINS_S)],
    ),
}
