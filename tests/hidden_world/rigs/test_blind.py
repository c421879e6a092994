"""Blind trials come from their seeds, leave no trace of the truth, and go through the causes in turn."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.hidden_world.rigs.blind import KINDS, drawn, first_cause, prepare
from tests.hidden_world.rigs.catalogue import ALL, CAUSES, UNLISTED
from tests.hidden_world.rigs.formula import _OF_ANOTHER_LAW, comparable
from tests.hidden_world.rigs.limits import held_out
from tests.hidden_world.rigs.rig import Effect

FILES = {"fast.csv", "frames.csv", "model.toml"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_the_same_files_and_no_truth_among_them(kind: str, tmp_path: Path) -> None:
    once, again = (prepare(kind, 2, 4, tmp_path / name) for name in ("once", "again"))
    assert once == again and json.loads(json.dumps(once, allow_nan=False)) == once
    assert {path.name for path in (tmp_path / "once").iterdir()} == FILES
    for file in FILES:
        assert (tmp_path / "once" / file).read_bytes() == (tmp_path / "again" / file).read_bytes()
    hidden = [effect["cause"] for effect in once["hidden"]]
    assert len(hidden) == {"none": 0, "two": 2}.get(kind, 1)
    assert all(cause in (UNLISTED if kind == "unknown" else CAUSES) for cause in hidden)
    assert hidden[:1] == ([] if kind == "none" else [first_cause(kind, 2, 4)])
    written = "".join((tmp_path / "once" / file).read_text() for file in FILES)
    assert not any(cause in written for cause in ALL)


@pytest.mark.parametrize(("kind", "pool"), [("one", CAUSES), ("two", CAUSES), ("unknown", UNLISTED)])
def test_every_cause_comes_once_before_any_comes_again(kind: str, pool: dict[str, object]) -> None:
    count = len(pool)
    order = [first_cause(kind, number, 7) for number in range(2 * count)]
    assert set(order[:count]) == set(order[count:]) == set(pool)
    assert order[:count] != order[count:]
    assert order != [first_cause(kind, number, 8) for number in range(2 * count)]


def test_a_kind_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="three"):
        drawn("three", 0, 0)


def test_ten_of_thirty_blocks_are_held_out_and_none_is_short() -> None:
    for duration_s, blocks in ((60.0, 30), (20.0, 24), (3.0, 9)):
        t = np.arange(0.0, duration_s, 1e-3)
        held = held_out(t, duration_s)
        assert np.sum(np.diff(held.astype(int)) == 1) == blocks // 3
        assert np.mean(held) == pytest.approx(1.0 / 3.0, abs=1e-3)
        assert not held[0] and not held[-1]


def test_forms_of_another_law_are_not_compared() -> None:
    for cause, forms in _OF_ANOTHER_LAW.items():
        assert set(forms) & set(ALL[cause].forms) and set(ALL[cause].forms) - set(forms)
    assert comparable(Effect("tracking_drift", "linear", 1.0, onset_s=9.0))
    assert not comparable(Effect("tracking_drift", "sqrt", 1.0))
    assert not comparable(Effect("delay_drift", "linear", 1.0, onset_s=9.0))
    assert comparable(Effect("quadratic_damping", "power", 1.0, extras={"power": 2.0}))
    assert not comparable(Effect("quadratic_damping", "power", 1.0, extras={"power": 1.9}))
