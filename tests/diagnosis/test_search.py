"""The search's stages, and what is left beside a candidate."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.candidate import Candidate, Found
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.choice import ALL
from stillarm.diagnosis.fit import fit, make_data, strayed
from stillarm.diagnosis.noise import Colour
from stillarm.diagnosis.search import _drop_needless, _lost, _of_fit, _rest_of, _under, block_gain, search
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.structure import examine
from tests.fixtures.synthetic import fitted, measured


def test_a_loud_sensor_in_which_no_cause_scores_has_nothing_wrong() -> None:
    """Noise of over a unit has a negative log-likelihood, which is below the zero of no refits at all."""
    data = measured(6.0, 8)
    unseen = np.full(data.cycles, np.nan)
    loud = np.random.default_rng(9).normal(0.0, 40.0, data.cycles)
    baseline = fitted(replace(data, acceleration=data.acceleration + loud, position=unseen, velocity=unseen))
    assert baseline.train_log_likelihood < -1000.0
    assert not search(baseline, interleaved(6.0), only=["joint_friction"]).findings


@pytest.mark.slow
def test_what_strays_is_not_cleared_by_what_is_fitted_beside_it() -> None:
    """Taken for noise on one side only, it would be all that is left without the candidate, and nothing with it."""
    data, split = measured(12.0, 8), interleaved(12.0)
    random, wander = np.random.default_rng(5), np.zeros(data.cycles)
    stay = np.exp(-1.0 / 1500.0)
    steps = random.normal(0.0, 0.25 * np.sqrt(1.0 - stay**2), data.cycles)
    for cycle in range(1, data.cycles):
        wander[cycle] = stay * wander[cycle - 1] + steps[cycle]
    last = fitted(replace(data, acceleration=data.acceleration + wander))
    made = make_data(last.world, split)
    strays = _under(made, last, strayed(made, last))
    assert strays is not None
    assert not examine(made, last).channels["acceleration"].white
    assert all(one.white for one in examine(made, strays).channels.values())
    gains = np.ones(len(split.held))
    one = Candidate("lens_distortion", strays, 30.0, 10.0, 1.0, gains, {})
    assert _rest_of(strays, frozenset(), split)(one) == ALL


@pytest.mark.slow
def test_a_step_by_the_edge_of_what_is_held_out_is_not_dropped() -> None:
    """A frame before it, taken for one behind it, is held out: what all others say of the step still counts."""
    seconds, step_s = 12.0, 0.02
    split = interleaved(seconds)
    times = np.arange(0.0, seconds, 0.001)
    held = split.held[split.blocks_of(times)]
    edge = float(times[np.flatnonzero(held[:-1] & ~held[1:])[1]])
    data = measured(seconds, 4, {"accelerometer.delay_s": 0.006})
    received = data.frames.received_s + step_s * (data.frames.received_s >= edge)
    data = replace(data, frames=replace(data.frames, received_s=received))
    names = ("timing.step_s", "accelerometer.delay_s")
    both = fitted(data, *names, split=split)
    made = make_data(both.world, split)
    early = both.world.space.with_values(
        both.vector, {"timing.step_onset_s": edge - 0.04, "timing.step_s": step_s}
    )
    wander = Colour(0.94, 0.0)  # of the delay, by steps of which the one sought is no rare one
    both = fit(made, early, both.free, colour={**both.colour, "arrival": wander})
    nothing = np.zeros(len(split.held))
    findings = [
        Candidate(cause, both, 0.0, 0.0, 0.0, nothing, {}) for cause in ("clock_step", "accelerometer_lag")
    ]
    found = Found(both, both, findings)
    plain = both.world.space.with_values(both.vector, {"timing.step_s": 0.0})
    without = fit(
        made, plain, tuple(name for name in both.free if name != "timing.step_s"), colour=both.colour
    )
    assert float(block_gain(both, without)[split.held].sum()) < 0.0
    _drop_needless(found, split)
    assert [one.cause for one in found.findings] == ["clock_step", "accelerometer_lag"]


@pytest.mark.parametrize(
    ("train", "certain", "lost"),
    [
        ([0.0, 0.0, 300.0], False, 1.0),  # in one place: it may be anything
        ([0.0, 0.0, 300.0], True, 301.0),  # as an accelerometer clips at one blow
        ([80.0, 5.0, 80.0], False, 166.0),  # as a clock's skew grows towards both ends
        ([80.0, -60.0, 80.0], False, 1.0),
    ],
)
def test_what_is_lost_with_a_finding(train: list[float], certain: bool, lost: float) -> None:
    """Where a cause need not show in what is held out, all data tell whether it is needless."""
    split = interleaved(6.0)
    without = fitted(measured(6.0, 5), split=split)
    blocks, held = np.zeros(len(split.held)), np.zeros(len(split.held))
    blocks[[0, 3, 8]], held[4] = train, 1.0
    final = replace(
        without, train_blocks=without.train_blocks + blocks, held_out_score=without.held_out_score + held
    )
    one = replace(_of_fit(CAUSES["accelerometer_clipping"], final, without, split), certain=certain)
    assert _lost(one, final, without, split) == pytest.approx(lost)
