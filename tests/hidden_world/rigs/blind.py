"""A blind trial: a bundle that holds no trace of what is hidden in it, and the truth, apart.

`prepare(kind, number, seed, folder)` draws rig, moves, effects, sizes and noise from the seed, writes fast.csv,
frames.csv and model.toml into the folder, and returns the truth as plain values.
"""

from pathlib import Path
from typing import Any

import numpy as np

from tests.hidden_world.rigs.bundle import write_data
from tests.hidden_world.rigs.case import LEAST_CLEAR, Case, all_clear, make
from tests.hidden_world.rigs.catalogue import ALL, CAUSES, UNLISTED, also
from tests.hidden_world.rigs.formula import comparable
from tests.hidden_world.rigs.limits import floor, least_nats, strongest

KINDS = ("one", "none", "unknown", "two")
_REDRAWS = 4


def prepare(kind: str, number: int, seed: int, folder: Path) -> dict[str, Any]:
    """Write trial `number` of a kind and of a campaign's seed; returns the truth as plain values.

    expected, cause, also, doubtful, size_in_noise: as in truth.json (bundle.py). hidden: of each effect its cause,
    form, onset_s, size_in_noise, parameters; same: causes that are the same law in this recording; matters: whether
    it asks for an answer of its own; comparable: whether its parameters are those of the cause's formula. floor: what
    the true model leaves of each channel where held out, rms over the channel's standard deviation there; strongest:
    the channel that the effects change most, None where nothing is hidden. oracle_nats: see limits.py. Raises
    ValueError for no such kind.
    """
    case = drawn(kind, number, seed)
    write_data(case, folder)
    return {
        "kind": kind,
        "seed": case.rig.seed,
        "duration_s": case.rig.duration_s,
        "expected": case.expected,
        "cause": case.cause,
        "also": case.also(),
        "doubtful": case.doubtful,
        "size_in_noise": max(case.sizes, default=0.0),
        "hidden": [
            {
                "cause": effect.cause,
                "form": effect.form,
                "onset_s": effect.onset_s,
                "size_in_noise": size,
                "parameters": ALL[effect.cause].told(case.rig, effect),
                "same": also(case.rig, effect),
                "matters": size >= LEAST_CLEAR,
                "comparable": comparable(effect),
            }
            for effect, size in zip(case.effects, case.sizes, strict=True)
        ],
        "floor": floor(case),
        "strongest": strongest(case),
        "oracle_nats": least_nats(case),
    }


def drawn(kind: str, number: int, seed: int) -> Case:
    """The case of a trial. Raises ValueError for no such kind.

    One of which it is open what should be answered is drawn anew, as is one of two effects that are not both plain: a
    few times, since some causes show on few rigs.
    """
    if kind not in KINDS:
        raise ValueError(f"{kind}: no kind of trial; there are {', '.join(KINDS)}")
    what = first_cause(kind, number, seed)
    for redraw in range(_REDRAWS):
        own = int(np.random.default_rng((seed, KINDS.index(kind), number, redraw)).integers(2**31))
        case = make(own, what, two=kind == "two")
        if not case.doubtful and (kind != "two" or all_clear(case)):
            break
    return case


def first_cause(kind: str, number: int, seed: int) -> str:
    """What a trial hides, of two effects the first: each once before any comes again, in an order that the seed
    shuffles; "none" for nothing."""
    if kind == "none":
        return "none"
    pool = list(UNLISTED if kind == "unknown" else CAUSES)
    turn, place = divmod(number, len(pool))
    return pool[int(np.random.default_rng((seed, KINDS.index(kind), turn)).permutation(len(pool))[place])]
