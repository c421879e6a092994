"""What a cause is: its name, what one sees of it, its parameters, and how it enters the simulation."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import isnan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import Cause as Declaration
from stillarm.common.causes import Parameter, Place
from stillarm.common.causes.declaration import OTHERS
from stillarm.diagnosis.events.frequency_course import Course, frequency_courses
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.declared_effects import quantity_of
from stillarm.diagnosis.physics.quantities import HIGHER
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
Overrides = Mapping[str, float]

MOST_PENALTY_NATS = 100.0
"""Most that a prior takes from a form: eight times what convinces, so that the data decide where they are plain."""
_LINEAR = 0.2  # of the least that is usual: what adds to a sensor does so in proportion
_TRIED = 4  # values across the usual range


@dataclass(frozen=True)
class Trial:
    """One way to look for a cause.

    shape: quantities set first (a frequency, an onset). columns: each a set of quantities whose effect, beside the
    shape, is one direction in which the data may depart. one_sided: only a positive amount of it makes sense.
    options: of the world (an extra mode, a play behind the encoder). exact: to be refitted from these very values,
    whatever its score, as they are worked out from the data, too far off for a score. certain: to be refitted whatever
    its score, and taken first, as the data themselves show it in a way that no small change of the simulation does.
    """

    shape: Overrides
    columns: tuple[Overrides, ...]
    one_sided: bool = False
    options: tuple[tuple[str, object], ...] = ()
    exact: bool = False
    certain: bool = False

    @property
    def asked(self) -> bool:
        """Whether it is to be refitted whatever its score."""
        return self.exact or self.certain


@dataclass(frozen=True)
class Context:
    """What a cause may look at to choose its trials: the fit so far, and peaks of its residuals' spectra, Hz."""

    fit: Fit
    peaks_hz: Mapping[str, tuple[float, ...]]

    @property
    def world(self) -> World:
        """The world fitted so far."""
        return self.fit.world

    def value(self, name: str) -> float:
        """A quantity as fitted."""
        return self.fit.value(name)

    def declared(self, name: str) -> float:
        """A quantity as the model has it: nothing of a cause, or what its effects say."""
        return self.world.space[name].start

    @property
    def amplitude_m(self) -> float:
        """Largest deflection of the first mode."""
        q = self.fit.predicted.motion.q[:, 0]
        return float(np.max(np.abs(q))) or 1e-3

    @property
    def top_command_rad_s(self) -> float:
        """Largest command."""
        return float(np.max(np.abs(self.world.measured.command))) if self.world.measured.cycles else 0.0

    @cached_property
    def _courses(self) -> dict[str, Course]:
        """How the arm's frequency is seen to go, as long as the fit has no course of it: beside the fit's answer to the
        joint, or beside the stated model's, whichever shows it more plainly. A fit of one frequency may be bent."""
        start = self.world.space.vector()
        names = ("arm.frequency_ratio", "arm.frequency_rate_per_s", "arm.cubic_per_m2")
        if any(self.value(name) != start[self.world.space.place[name]] for name in names):
            return {}
        found = frequency_courses(self.world, self.fit.predicted.motion)
        for cause, course in frequency_courses(self.world, self.world.predict(start).motion).items():
            if cause not in found or course.nats > found[cause].nats:
                found[cause] = course
        return found

    def along_a_course(self, cause: str, name: str) -> list["Trial"]:
        """Trials that start from how the arm's frequency is seen to go, if as the cause has it, higher modes with it or
        not; name: its own."""
        course = self._courses.get(cause)
        if course is None:
            return []
        # as the model has it: one frequency's fit has bent all else to make up for it
        shape = {other: self.world.space[other].start for other in self.world.baseline_names()}
        return [
            Trial(
                shape | {other: value for other, value in begun.items() if other != name},
                ({name: begun[name]},),
                exact=True,
            )
            for begun in course.starts(self.world)
        ]

    def onsets(self, count: int) -> list[float]:
        """Evenly spread instants at which something may have begun, s."""
        length = self.world.measured.duration_s
        return [float(x) for x in np.linspace(0.04 * length, 0.96 * length, count)]


Values = dict[str, tuple[float, float]]


SHARE = "higher_modes_share"


@dataclass(frozen=True)
class Cause:
    """How one cause of the catalogue (common/causes.py has its name, equation, parameters) is found and fitted.

    free: quantities of the vector that a refit frees. trials: where to look. parameters_of: the contract's parameters
    with standard deviations, from a fit. settle: quantities without a smooth derivative, with the first step of a
    search along them. surprise: nats by which a fit's values are unlikely for this cause, before any data. possible:
    whether a fit's values are such a cause's at all.
    """

    id: str
    needs: Callable[[World], bool]
    trials: Callable[[Context], list[Trial]]
    free: Callable[[World], tuple[str, ...]]
    parameters_of: Callable[[Fit], Values]
    settle: Mapping[str, float] = field(default_factory=dict)
    prior_penalty: Callable[[Fit], float] = lambda fit: 0.0
    possible: Callable[[Fit], bool] = lambda fit: True


def has(*names: str) -> Callable[[World], bool]:
    """Whether any of the channels was measured."""
    return lambda world: any(name in world.channels for name in names)


def arm_moves(world: World) -> bool:
    """Whether anything measured shows the arm's bending."""
    return any(name in world.channels for name in ("acceleration", "deflection", "displacement"))


def driven(world: World) -> bool:
    """Whether the joint was commanded, and anything shows it."""
    if world.measured.imposed:
        return False
    command = world.measured.command
    moving = bool(np.any(np.abs(np.nan_to_num(command)) > 0.0)) and not world.measured.pair
    return moving and any(
        name in world.channels
        for name in ("acceleration", "displacement", "joint_position", "joint_velocity")
    )


def free_of(*names: str) -> Callable[[World], tuple[str, ...]]:
    """Always the same quantities."""
    return lambda world: names


def of_the_modes(*names: str) -> Callable[[World], tuple[str, ...]]:
    """The same quantities, and where there are more modes, the share that they take in a change of frequency."""
    return lambda world: (*names, HIGHER) if world.modes > 1 else names


def share_of(fit: Fit) -> Values:
    """The share of a change of frequency that higher modes take, where there are some."""
    return {SHARE: (fit.value(HIGHER), fit.std.get(HIGHER, 0.0))} if fit.world.modes > 1 else {}


def plain(fit: Fit, **names: str) -> Values:
    """Parameters that are quantities of the vector: parameter=quantity."""
    return {parameter: (fit.value(name), fit.std.get(name, 0.0)) for parameter, name in names.items()}


def size_of_wave(fit: Fit, sine: str, cosine: str) -> tuple[float, float]:
    """Amplitude of a sine and a cosine part, with its standard deviation."""
    a, b = fit.value(sine), fit.value(cosine)
    size = float(np.hypot(a, b))
    if size == 0.0:
        return 0.0, 0.0
    return size, float(np.hypot(a * fit.std.get(sine, 0.0), b * fit.std.get(cosine, 0.0)) / size)


_NEEDS: dict[Place, Callable[[World], bool]] = {
    "arm": arm_moves,
    "drive": driven,
    "accelerometer": has("acceleration"),
    "camera": has("displacement"),
    "timing": has("displacement", "arrival"),
}


def declared_cause(cause: Declaration) -> Cause:
    """Its trials are its usual sizes, to both sides where signed, beside usual values of its other numbers."""
    names = {one.name: quantity_of(cause.identifier, one.name) for one in cause.numbers}
    sizes = [one for one in cause.numbers if _is_size(cause, one)]
    others = [one for one in cause.numbers if one not in sizes]
    moves = cause.place in ("arm", "drive")

    def shown_in(world: World) -> dict[str, str]:
        """Quantities by parameter, but for what only an arm of several modes shows."""
        alone = world.modes == 1
        return {name: quantity for name, quantity in names.items() if not (alone and name == OTHERS.name)}

    def trials(context: Context) -> list[Trial]:
        found = []
        for values in product(*(_begins(one) for one in others)):
            shape = {names[one.name]: value for one, value in zip(others, values, strict=True)}
            for amounts in zip(*(_amounts(one, moves) for one in sizes), strict=True):
                known = {names[one.name]: context.value(names[one.name]) for one in sizes}
                column = {name: known[name] + more for name, more in zip(known, amounts, strict=True)}
                one_sided = not any(one.signed for one in sizes) and not any(known.values())
                found.append(Trial(shape, (column,), one_sided=one_sided))
        return found

    return Cause(
        id=cause.identifier,
        needs=_NEEDS[cause.place],
        trials=trials,
        free=lambda world: tuple(shown_in(world).values()),
        parameters_of=lambda fit: plain(fit, **shown_in(fit.world)),
    )


def _is_size(cause: Declaration, one: Parameter) -> bool:
    return bool(cause.key) or not isnan(one.neutral)


def _begins(one: Parameter) -> tuple[float, ...]:
    """Values of a number that is no size from which a search begins."""
    if one.tried or one.default is not None:
        return one.tried or (float(one.default or 0.0),)
    return tuple(np.geomspace(*one.typical, _TRIED).tolist())


def _amounts(one: Parameter, moves: bool) -> tuple[float, ...]:
    """By how much more a size is tried."""
    low, high = one.typical
    if not moves:
        return (_LINEAR * low,)
    return (low, high, -low, -high) if one.signed else (low, high)


@dataclass(frozen=True)
class Form:
    """One form of a cause. name: in words; empty for the declared one. added: terms that its fit needs, from the fit so
    far. begins: the quantity of its onset, where it has one; throughout: the same form without. nats_of: what a law
    for which the terms stand gains over the fit so far, less what its numbers cost; none where the terms are worth what
    they foretell."""

    cause: Cause
    name: str = ""
    added: Callable[[Fit], tuple[Added, ...]] | None = None
    begins: str | None = None
    throughout: "Form | None" = None
    nats_of: Callable[[Fit], float] | None = None

    @property
    def id(self) -> str:
        """The cause's identifier."""
        return self.cause.id
