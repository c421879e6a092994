"""A whole case from a seed: a rig, its moves, nuisance that stays below what matters, effects of a drawn size."""

from dataclasses import dataclass, replace

import numpy as np

from tests.hidden_world.rigs.arm_effects import CHANGES
from tests.hidden_world.rigs.catalogue import ALL, CAUSES, UNLISTED, also
from tests.hidden_world.rigs.departure import Departure, clearness, departures, of_noise
from tests.hidden_world.rigs.draw import draw_effect, draw_rig, resized
from tests.hidden_world.rigs.moves import Move, draw_moves
from tests.hidden_world.rigs.recording import Recording, record
from tests.hidden_world.rigs.rig import Effect, Rig, log_uniform, luck

_RANGES = (19.6, 39.2, 78.4, 156.8)
_SIZES = (1.8, 120.0)
_HARDLY = (0.01, 0.1)
_SHARE_HARDLY = 0.06
LEAST_CLEAR, _MOST_HIDDEN = 1.3, 0.15
"""Between these sizes it is doubtful what should be answered."""
_CLOSE_ENOUGH = 1.4
_MOST_OF_NOISE = 0.3
_ATTEMPTS = 8
_FEWEST_MOVES = 4
_MOST_NUISANCE = 0.45


@dataclass(frozen=True)
class Case:
    """What is written. sizes: of each effect alone, over the noise of the channel that it changes most, after a
    refit; seen: by channel, of all of them; raw: the same without a refit; nuisance: the same of what no cause
    describes, without a refit."""

    rig: Rig
    moves: list[Move]
    effects: tuple[Effect, ...]
    recording: Recording
    sizes: tuple[float, ...]
    seen: dict[str, Departure]
    raw: dict[str, Departure]
    nuisance: float
    expected: str
    doubtful: bool

    @property
    def cause(self) -> str | None:
        """The largest effect's; None where nothing is hidden."""
        return self._first().cause if self.effects else None

    def also(self) -> list[str]:
        """What may stand first as well: the same law here, or another effect of a similar size."""
        if not self.effects or self.expected != "named":
            return []
        first = self._first()
        others = [
            e.cause
            for e, s in zip(self.effects, self.sizes, strict=True)
            if e is not first and 4.0 * s > max(self.sizes)
        ]
        return also(self.rig, first) + others

    def _first(self) -> Effect:
        return self.effects[int(np.argmax(self.sizes))]


def make(seed: int, what: str = "mixed", two: bool = False) -> Case:
    """The case of a seed. what: a cause, an unlisted effect, "none", "unlisted" or "mixed". Raises KeyError for no
    such.

    A rig on which the effect would neither matter clearly nor be lost in the noise clearly is drawn anew, and so is
    one on which hardly anything is done.
    """
    chance = luck(seed, 1)
    causes = _chosen(what, two, chance)
    hardly = len(causes) == 1 and chance.random() < _SHARE_HARDLY
    hardly = hardly and ALL[causes[0]].fitted
    for attempt in range(_ATTEMPTS):
        case = _made(seed * _ATTEMPTS + attempt, causes, hardly)
        if len(case.moves) >= _FEWEST_MOVES and not case.doubtful and (hardly or all_clear(case)):
            break
    return case


def all_clear(case: Case) -> bool:
    """Whether the rig shows each effect plainly."""
    return all(size >= LEAST_CLEAR for size in case.sizes)


def _doubtful(sizes: list[float], seen: dict[str, Departure]) -> bool:
    """Whether it is open what should be answered."""
    if any(_MOST_HIDDEN < size < LEAST_CLEAR for size in sizes):
        return True
    return bool(sizes) and max(sizes) <= _MOST_HIDDEN and of_noise(seen) > _MOST_OF_NOISE


def _made(seed: int, causes: list[str], hardly: bool) -> Case:
    chance = luck(seed, 2)
    needs = {ALL[cause].needs for cause in causes}
    rig = draw_rig(seed, needs, one_mode="second_bending_mode" in causes)
    moves = draw_moves(rig)
    rig = _ranged(
        rig, moves
    )  # first: what a sensor at its limit does not show is too little to scale a nuisance by
    rig, nuisance = _with_nuisance(rig, moves, chance)
    plain = record(rig, moves, noise=False)
    effects, sizes = [], []
    for number, cause in enumerate(causes):
        effect = draw_effect(cause, rig, plain, number)
        wanted = log_uniform(chance, *(_HARDLY if hardly else _SIZES))
        effect, size = _sized(effect, rig, moves, plain, wanted)
        effects.append(effect)
        sizes.append(size)
    hidden = tuple(effects)
    motion = None if any(e.cause in CHANGES for e in hidden) else plain.motion
    changed = record(rig, moves, hidden, False, motion)
    seen = departures(changed, plain, moves) if hidden else {}
    raw = departures(changed, plain) if hidden else {}
    recording = record(rig, moves, hidden, True, changed.motion)
    matters = any(d.matters for d in seen.values())
    listed = any(e.cause in CAUSES for e in hidden)
    expected = "none" if not matters else "named" if listed else "unexplained"
    doubtful = _doubtful(sizes, seen)
    return Case(rig, moves, hidden, recording, tuple(sizes), seen, raw, nuisance, expected, doubtful)


def _chosen(what: str, two: bool, chance: np.random.Generator) -> list[str]:
    names = list(CAUSES)
    if what == "mixed" and not two:
        what = str(chance.choice(["one", "unlisted", "none", "two"], p=[0.6, 0.15, 0.15, 0.1]))
    if what == "none":
        return []
    if what == "unlisted":
        return [str(chance.choice(list(UNLISTED)))]
    if what not in ALL and what not in ("mixed", "one", "two"):
        raise KeyError(what)
    first = what if what in ALL else str(chance.choice(names))
    if two or what == "two":
        return [first, str(chance.choice([n for n in names if n != first]))]
    return [first]


def _with_nuisance(rig: Rig, moves: list[Move], chance: np.random.Generator) -> tuple[Rig, float]:
    """The rig with its nuisance scaled to between nothing and a little below what matters."""
    if rig.nuisance.third is None and rig.nuisance.warmth == 0.0 and rig.nuisance.skew == 0.0:
        return rig, 0.0
    without = record(rig, moves, noise=False, nuisance=False)
    wanted = float(chance.uniform(0.02, _MOST_NUISANCE))
    size = 0.0
    for _ in range(3):
        size = of_noise(departures(record(rig, moves, noise=False), without))
        if size <= _MOST_NUISANCE:
            break
        rig = _scaled(rig, wanted / size)
    return rig, size


def _scaled(rig: Rig, factor: float) -> Rig:
    mine = rig.nuisance
    third = mine.third and replace(mine.third, participation=mine.third.participation * factor)
    return replace(
        rig, nuisance=replace(mine, third=third, warmth=mine.warmth * factor, skew=mine.skew * factor)
    )


def _ranged(rig: Rig, moves: list[Move]) -> Rig:
    """The accelerometer's range beyond all but impacts."""
    if rig.accelerometer is None:
        return rig
    plain = record(rig, moves, noise=False, nuisance=False)
    peak = 1.4 * float(np.quantile(np.abs(plain.motion.tip_m_s2[::10]), 0.9995))
    enough = next((r for r in _RANGES if r > peak), _RANGES[-1])
    return replace(rig, accelerometer=replace(rig.accelerometer, range_m_s2=enough))


def _sized(
    effect: Effect, rig: Rig, moves: list[Move], plain: Recording, wanted: float
) -> tuple[Effect, float]:
    """The effect with a size that changes a channel by so many times its noise after a refit, and what it comes to."""
    motion = None if effect.cause in CHANGES else plain.motion

    def measured(trial: Effect) -> float:
        return clearness(departures(record(rig, moves, (trial,), False, motion), plain, moves))

    size = measured(effect)
    if not ALL[effect.cause].fitted:
        return effect, size
    for _ in range(4):
        if size > 0.0 and 1.0 / _CLOSE_ENOUGH < size / wanted < _CLOSE_ENOUGH:
            break
        before = effect.size
        step = float(np.clip(wanted / max(size, 1e-9), 1e-3, 1e3))
        effect = resized(effect, effect.size * step)
        if effect.size == before:
            break
        size = measured(effect)
    return effect, size
