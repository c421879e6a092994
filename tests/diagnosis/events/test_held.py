"""Something holds the arm and lets it go: found with beginning and end, and none where the arm swings freely."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events import pulls as module
from stillarm.diagnosis.events.held import bend, held_spans_s
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.events.pulls import without_pulls
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, NOISE, fitted, measured

SECONDS, SPLIT = 24.0, interleaved(24.0)
HZ, DAMPING = MODEL.arm.modes[0].frequency_hz, MODEL.arm.modes[0].damping_ratio
PX_PER_M = -MODEL.camera.scale_px_per_m  # the image moves against the tip


Pulls = tuple[tuple[float, float, float], ...]


def pulled(pulls: Pulls) -> Measured:
    """Measured of an arm at rest that is pulled aside: each from, let go at, s, and how far, m. The force grows in two
    thirds of the time. Solved by another method than the diagnosis'."""
    bare = measured(SECONDS, 3)
    w = 2.0 * pi * HZ

    def force(t: float) -> float:
        return sum(
            w * w * far * min((t - start) / (0.67 * (end - start)), 1.0)
            for start, end, far in pulls
            if start <= t < end
        )

    time = np.arange(bare.cycles) * bare.cycle_s
    state, q, qdd = np.zeros(2), np.zeros(len(time)), np.zeros(len(time))
    edges = [0.0, *(edge for one in pulls for edge in one[:2]), SECONDS]
    for start, end in pairwise(edges):
        inside = (time >= start) & (time < end)
        solved = solve_ivp(
            lambda t, x: [x[1], force(t) - 2.0 * DAMPING * w * x[1] - w * w * x[0]],
            (start, end), state, t_eval=np.append(time[inside], end), max_step=5e-3, rtol=1e-8, atol=1e-12,
        )  # fmt: skip
        q[inside], state = solved.y[0, :-1], solved.y[:, -1]
        forced = np.array([force(t) for t in time[inside]])
        qdd[inside] = forced - 2.0 * DAMPING * w * solved.y[1, :-1] - w * w * q[inside]
    seen = World(bare, MODEL)
    exposed = seen.instants(seen.space.vector())
    more_px = PX_PER_M * np.interp(exposed, time, q)
    frames = replace(bare.frames, displacement_px=bare.frames.displacement_px + more_px)
    return replace(bare, acceleration=bare.acceleration + qdd, frames=frames)


@cache
def fitted_to(pulls: Pulls) -> Fit:
    """The baseline's fit to an arm that is pulled."""
    return fit_with_impacts(World(pulled(pulls), MODEL), SPLIT)


PULLS = ((6.0, 8.5, 0.02), (9.2, 11.9, -0.006), (13.5, 16.0, 0.012))
SOON = ((6.0, 8.5, 0.02), (8.55, 10.4, -0.02))  # held again before the first is seen to be over
NEXT = ((6.0, 8.5, 0.02), (8.8, 10.6, 0.02))  # before the arm has swung once


@pytest.mark.slow
@pytest.mark.parametrize("pulls", [PULLS[:1], PULLS, SOON, NEXT], ids=["one", "three", "soon", "next"])
def test_slow_pulls_are_left_out_from_their_beginning_to_their_release(pulls: Pulls) -> None:
    baseline = without_pulls(fitted_to(pulls), SPLIT)
    for start, end, _ in pulls:
        assert any(a < start + 0.15 and b > end - 0.01 for a, b in baseline.world.unjudged_s)
    # nothing is judged between two in less than a swing
    assert all(b < a - 0.9 / HZ for (_, b), (a, _) in pairwise(baseline.world.unjudged_s))
    assert sum(b - a for a, b in baseline.world.unjudged_s) < 2.0 * sum(b - a for a, b, _ in pulls)
    for name in ("acceleration", "displacement"):
        assert np.nanstd(baseline.residuals[name]) == pytest.approx(NOISE[name], rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("jump", [0.02, -0.05])
def test_an_impact_is_no_pull(jump: float) -> None:
    data = measured(SECONDS, 3, {"jump.1.0.v": 2.0 * pi * HZ * jump}, impacts=(9000,))
    assert held_spans_s(fit_with_impacts(World(data, MODEL), SPLIT)) == ()


@pytest.mark.slow
@pytest.mark.parametrize("faster_hz", [0.1, 0.2])
@pytest.mark.parametrize("struck", [9000, 9100, 9200])
def test_a_swing_that_the_model_has_wrong_is_no_pull(struck: int, faster_hz: float) -> None:
    """It bends the arm from its impact until its first half is over, and departs from the model there."""
    values = {"jump.0.0.q": 0.0, "jump.1.0.v": 2.0 * pi * HZ * 0.03}
    faster = {"modes.0.frequency_hz": HZ + faster_hz}
    world = World(measured(SECONDS, 3, values | faster, impacts=(struck,)), MODEL, (struck,))
    wrong = world.space.with_values(world.space.vector(), values)
    assert held_spans_s(fit(make_data(world, SPLIT), wrong, (), iterations=0)) == ()


@pytest.mark.slow
def test_a_slow_course_of_the_images_without_a_release_is_no_pull() -> None:
    data = measured(SECONDS, 3)
    time = World(data, MODEL).instants(World(data, MODEL).space.vector())
    strayed = data.frames.displacement_px + 8.0 * np.sin(2.0 * pi * 0.08 * time)
    data = replace(data, frames=replace(data.frames, displacement_px=strayed))
    assert held_spans_s(fit_with_impacts(World(data, MODEL), SPLIT)) == ()


@pytest.mark.slow
@pytest.mark.parametrize(("wrong_everywhere", "left_out"), [(True, False), (False, True)])
def test_a_span_is_believed_if_the_images_are_told_elsewhere(
    monkeypatch: pytest.MonkeyPatch, wrong_everywhere: bool, left_out: bool
) -> None:
    """A lens that bends all images bends those of any span as well."""
    span = (6.0, 8.5)
    data = measured(SECONDS, 3, {"camera.lens_per_px2": 2e-4} if wrong_everywhere else {})
    monkeypatch.setattr(module, "held_spans_s", lambda last: () if last.world.unjudged_s else (span,))
    monkeypatch.setattr(module, "pull_spans_s", lambda last: ())
    world = World(data, MODEL)
    plain = fit(make_data(world, SPLIT), world.space.vector(), world.baseline_names())
    assert (without_pulls(plain, SPLIT).world.unjudged_s == (span,)) is left_out


@pytest.mark.filterwarnings("error")
def test_a_span_in_which_no_image_was_taken_does_not_stand_out() -> None:
    data, span = measured(SECONDS, 3), (6.0, 8.5)
    time = data.frames.received_s
    px = np.where((time > span[0]) & (time < span[1] + 1.0), np.nan, data.frames.displacement_px)
    last = fitted(replace(data, frames=replace(data.frames, displacement_px=px)))
    assert not module._stand_out([span], last)


def test_without_images_nothing_is_seen() -> None:
    data = measured(SECONDS, 3)
    unseen = replace(data.frames, displacement_px=np.full(len(data.frames.displacement_px), np.nan))
    assert bend(fit_with_impacts(World(replace(data, frames=unseen), MODEL), SPLIT)) is None


@pytest.mark.slow
def test_a_bend_is_told_in_pixels() -> None:
    seen = bend(fitted_to(PULLS[:1]))
    assert seen is not None
    time, bent, width_s = seen
    held = (time > 8.0) & (time < 8.5 - 0.5 * width_s)
    assert held.any()
    assert float(np.median(bent[held])) == pytest.approx(PX_PER_M * 0.02, rel=0.15)
