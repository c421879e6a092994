"""What a drive's form can leave elsewhere, from how much of it is left at the joint."""

from dataclasses import replace
from math import inf

import pytest

from stillarm.diagnosis.candidate import Candidate, Found
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.fit import Data, Fit, fit, make_data
from stillarm.diagnosis.noise import Colour
from stillarm.diagnosis.search import _of_fit
from stillarm.diagnosis.seen_at_joint import most_left_elsewhere
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.structure import Remains, Structure
from stillarm.diagnosis.structure import examine as real_examine
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(6.0)
DATA = measured(6.0, 3, {"drive.velocity_loss_rad_s": 0.02})
PLAIN = fitted(DATA)
FRICTION = _of_fit(CAUSES["joint_friction"], fitted(DATA, "drive.velocity_loss_rad_s"), PLAIN, SPLIT)
LEAST = 10.0


def leaves(monkeypatch: pytest.MonkeyPatch, nats: float) -> list[Fit]:
    """Every fit leaves so much at the joint; which were asked."""
    asked = []

    def examine(data: Data, last: Fit, known_laws: frozenset[str]) -> Remains:
        asked.append(last)
        joint = Structure("joint_position", False, nats, 0.0, nats, (0.0, 0.0), "", "")
        remains = real_examine(data, last, known_laws)
        return replace(remains, channels=remains.channels | {"joint_position": joint})

    monkeypatch.setattr("stillarm.diagnosis.seen_at_joint.examine", examine)
    return asked


def most(one: Candidate) -> dict[str, float]:
    return most_left_elsewhere(Found(PLAIN, one.fit, [one]), SPLIT, LEAST)


def test_it_is_in_the_ratio_of_what_is_left_at_the_joint_of_what_was_explained_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    unseen = most(FRICTION)["joint_friction"]
    assert 0.0 < unseen < 0.05 * FRICTION.gain
    leaves(monkeypatch, LEAST)
    assert most(FRICTION)["joint_friction"] == unseen
    leaves(monkeypatch, 7.0 * LEAST)
    assert most(FRICTION)["joint_friction"] == pytest.approx(7.0 * unseen)


def test_what_strays_at_the_joint_is_counted_as_left_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit in which it is noise would leave nothing."""
    asked = leaves(monkeypatch, 0.0)
    colour = {**FRICTION.fit.colour, "joint_position": Colour(0.9, 0.0)}
    strayed = fit(make_data(PLAIN.world, SPLIT), FRICTION.fit.vector, FRICTION.fit.free, colour=colour)
    most_left_elsewhere(Found(PLAIN, strayed, [FRICTION]), SPLIT, LEAST)
    assert "joint_position" not in asked[0].colour


def test_where_the_joint_tells_nothing_there_is_no_bound() -> None:
    behind = fitted(DATA, "drive.velocity_loss_rad_s")
    behind.world = behind.world.changed(behind_encoder=True)
    assert most(replace(FRICTION, fit=behind))["joint_friction"] == inf
    assert most(replace(FRICTION, fit=PLAIN))["joint_friction"] == inf
    assert most(replace(FRICTION, cause="cubic_stiffness")) == {}
