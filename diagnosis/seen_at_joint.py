"""What a drive's simple form can leave of its true one elsewhere, by how much of it the joint's sensor shows."""

from math import inf

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.candidate import Candidate, Found
from stillarm.diagnosis.fit import Fit, Split, fit, make_data, train_nats_of_channels
from stillarm.diagnosis.structure import examine

_AT_JOINT = ("joint_position", "joint_velocity")
_AS_AT_JOINT = 3.0
"""Times the share that is left at the joint: measured 1 to 2 times, where a friction's form was too simple."""


def most_left_elsewhere(found: Found, split: Split, least: float) -> dict[str, float]:
    """Nats of all that its simple form may leave elsewhere, by each of the drive's findings: what it explained there,
    in the ratio of what is left of it at the joint. Infinite where the joint tells nothing of it.

    least: nats that go unseen.
    """
    of_drive = [one for one in found.findings if one.law is None and CATALOGUE[one.cause].place == "drive"]
    if not of_drive:
        return {}
    final = _with_white_joint(found.final, split)
    left = examine(make_data(final.world, split), final, found.known_laws).left
    at_joint = max(sum(left.get(name, 0.0) for name in _AT_JOINT), least)
    return {one.cause: _of_one(one, found, split, at_joint, least) for one in of_drive}


def _of_one(one: Candidate, found: Found, split: Split, left_at_joint: float, least: float) -> float:
    """Of one finding."""
    earlier = found.findings[: found.findings.index(one)]
    before = next((each.fit for each in reversed(earlier) if each.law is None), found.baseline)
    was, now = (_nats_of_channels(fitted, split) for fitted in (before, one.fit))
    gains = {name: nats - was[name] for name, nats in now.items()}
    at_joint = sum(gains.pop(name, 0.0) for name in _AT_JOINT)
    if at_joint <= least or one.fit.world.behind_encoder:
        return inf
    elsewhere = max(sum(gains.values()), 0.0) * one.gain / one.train_gain
    return _AS_AT_JOINT * left_at_joint / at_joint * elsewhere


def _with_white_joint(one: Fit, split: Split) -> Fit:
    """A fit as it is judged where what strays at the joint is no noise."""
    colour = {name: law for name, law in one.colour.items() if name not in _AT_JOINT}
    return fit(make_data(one.world, split), one.vector, (), iterations=0, colour=colour)


def _nats_of_channels(one: Fit, split: Split) -> dict[str, float]:
    return train_nats_of_channels(make_data(one.world, split), _with_white_joint(one, split))
