"""A blind trial: a bundle that holds no trace of what is hidden in it, and the answer, apart.

`prepare(kind, number, seed, folder)` draws cause, size, sign, onset, arm, manoeuvres and noise from the seed, writes
fast.csv, frames.csv and model.toml into the folder, and returns the truth as plain values.
"""

from dataclasses import replace
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np

from tests.hidden_world.bundle import FAST, FRAMES, write_bundle
from tests.hidden_world.draw import departure_of, draw_case
from tests.hidden_world.effects import CAUSES, UNKNOWN, Effect
from tests.hidden_world.oracle import Oracle, fitted_plain, scale_to
from tests.hidden_world.rig import TICK_S
from tests.hidden_world.world import Case, Recording, make

KINDS = ("one", "none", "unknown", "two")
CLEAR_NATS = 50.0
"""What a graded case is worth at least."""
_MOST_NATS = 800.0
_REDRAWS = 8
_MOST_DETAIL = 1.0 / 3.0
"""Of an effect's nats, what its plain form may leave: more, and another cause may well describe it better."""
_FINER = 3


def prepare(
    kind: str, number: int, seed: int, folder: Path, duration_s: float | None = None, cause: str | None = None
) -> dict[str, Any]:
    """Write trial `number` of a campaign's seed; returns the truth as plain values.

    hidden: {cause, parameters (the plain form's best fit), departure, nats} of each effect. hold_out: [from, to] in
    s, which no fit may use. floor: what the true model would leave of each channel there, rms over its standard
    deviation. strongest: the channel that shows it most, over_noise: its rms there in units of the noise's.
    cause: instead of a drawn one, for kind one.
    """
    for redraw in range(_REDRAWS):
        own = int(np.random.default_rng((seed, KINDS.index(kind), number, redraw)).integers(2**31))
        names = (cause,) if cause else names_of(kind, number, seed + redraw if kind == "two" else seed)
        case = draw_case(own, names, None, duration_s)
        oracle = Oracle(case)
        random = np.random.default_rng((own, 51))
        for which in range(len(names)):
            aim = exp(random.uniform(log(1.2 * CLEAR_NATS), log(_MOST_NATS)))
            case = _sized(case, aim, which, oracle)
        alone = [oracle.nats(replace(case, effects=(e,)), to_the_end=True) for e in case.effects]
        fits = [
            fitted_plain(case, which, oracle=oracle) for which in range(len(names)) if names[which] in CAUSES
        ]
        rough = [nats for _, nats in fits] or [0.0] * len(alone)
        if all(_clear(nats, beside) for nats, beside in zip(alone, rough, strict=True)):
            break
    else:
        raise ValueError(f"{names}: no draw of seed {seed}, trial {number}, shows it at {CLEAR_NATS} nats")
    fitted = [plain for plain, _ in fits] or list(case.effects)
    recording = make(case)
    write_bundle(recording, folder)
    shown = oracle.by_channel(case) if case.effects else {}
    strongest = max(shown, key=shown.__getitem__) if shown else None
    return {
        "kind": kind,
        "seed": own,
        "duration_s": case.duration_s,
        "damped": case.damped,
        "hidden": [_told(case, *one) for one in zip(case.effects, fitted, alone, rough, strict=True)],
        "hold_out": hold_out(case.duration_s),
        "floor": _floor(recording),
        "strongest": _COLUMN.get(strongest or ""),
        "over_noise": shown[strongest][1] if strongest else 0.0,
    }


def names_of(kind: str, number: int, seed: int) -> tuple[str, ...]:
    """What a trial hides: every name once before any comes again, in an order that the seed shuffles.

    Two at once come from different places (arm, drive, accelerometer, camera, timing).
    """
    if kind == "none":
        return ()
    pool = list(UNKNOWN if kind == "unknown" else CAUSES)
    turn = np.random.default_rng((seed, 61, number // len(pool)))
    first = pool[int(turn.permutation(len(pool))[number % len(pool)])]
    if kind != "two":
        return (first,)
    others = [name for name in CAUSES if CAUSES[name].where != CAUSES[first].where]
    return (first, others[int(np.random.default_rng((seed, 62, number)).integers(len(others)))])


_COLUMN = {source: column for column, (source, _) in (FAST | FRAMES).items()}


def _sized(case: Case, aim: float, which: int, oracle: Oracle) -> Case:
    """At about so many nats, its details made finer while the plain form describes too little of them."""
    case = scale_to(case, aim, which, oracle)
    for _ in range(_FINER):
        if case.effects[which].name not in CAUSES:
            return case
        nats = oracle.nats(replace(case, effects=(case.effects[which],)))
        if fitted_plain(case, which, oracle=oracle)[1] <= _MOST_DETAIL * nats:
            return case
        finer = replace(case.effects[which], detail=0.5 * case.effects[which].detail)
        effects = tuple(finer if place == which else e for place, e in enumerate(case.effects))
        case = scale_to(replace(case, effects=effects), aim, which, oracle)
    return case


def _clear(nats: float, detail_nats: float) -> bool:
    """Whether a recording shows an effect, and its plain form is what it shows."""
    return CLEAR_NATS <= nats < float("inf") and detail_nats <= max(_MOST_DETAIL * nats, 1.0)


def _told(case: Case, effect: Effect, fitted: Effect, nats: float, detail_nats: float) -> dict[str, Any]:
    known = effect.name in CAUSES
    return {
        "cause": effect.name,
        "variant": effect.kind,
        "parameters": dict(fitted.values),
        "size": CAUSES[effect.name].size if known else "amount",
        "departure": departure_of(fitted, case.rig),
        "law": known and CAUSES[effect.name].law,
        "nats": nats,
        "detail": effect.detail,
        "detail_nats": detail_nats,
    }


def hold_out(duration_s: float) -> list[list[float]]:
    """Every third of thirty blocks."""
    block = duration_s / 30.0
    return [[round(k * block, 3), round((k + 1) * block, 3)] for k in range(1, 30, 3)]


def _floor(recording: Recording) -> dict[str, float]:
    """A triggered exposure's instant is known to the tick only: what that leaves is part of the floor."""
    out, case = {}, recording.case
    for source in ("acceleration", "angle", "speed", "image"):
        at = recording.received if source == "image" else recording.time
        held = np.any([(at >= begin) & (at < end) for begin, end in hold_out(case.duration_s)], axis=0)
        measured, clean = getattr(recording, source), recording.truth[source]
        if source not in case.kept or np.sum(held) < 2:
            continue
        left = float(np.mean((measured - clean)[held] ** 2))
        if source == "image" and not case.rig.eye.free:
            exposed = recording.truth["middle_s"]
            middle, first = np.unique(exposed, return_index=True)  # an old image comes twice
            rate = np.interp(exposed, middle, np.gradient(clean[first], middle))
            left += float(np.mean(rate[held] ** 2)) * TICK_S**2 / 12.0
        out[_COLUMN[source]] = float(np.sqrt(left) / np.std(measured[held]))
    return out
