"""Walks whose rate is learnt: by a scalar filter of their own, and inside the fused method."""

import msgspec
import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.dates.evidence import Evidence
from stillarm.controller.estimation.fused.filters import start
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.jumps import loosen
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAWS, Law
from stillarm.controller.estimation.fused.filters.new_beginning import forget_phase
from stillarm.controller.estimation.fused.learning.learnt_walks import LearntWalk, LearntWalks, LearntWander
from stillarm.controller.estimation.fused.method import FusedMethod
from tests.reference.ringing_world import judge, model_for, ring

AMPLITUDE = 0.006


def filtered(true_share: float, seed: int, *, learn: bool = True) -> tuple[float, float, float]:
    """A random walk of unit variance a second, true_share of it, seen ten times a second with unit noise.

    Returns normalised error squared, error squared, and the share's logarithm, means over the second half of 1200 s.
    """
    random = np.random.default_rng(seed)
    walk, dt = LearntWalk(), 0.1
    truth = value = 0.0
    variance = 1.0
    ratios, errors, shares = [], [], []
    for k in range(12000):
        truth += np.sqrt(true_share * dt) * random.standard_normal()
        variance += (walk.share if learn else 1.0) * dt
        gain = variance / (variance + 1.0)
        value += gain * (truth + random.standard_normal() - value)
        variance *= 1.0 - gain
        if k % 15 == 14:
            walk.see(value, variance, 15 * dt)
        if k >= 6000:
            errors.append((value - truth) ** 2)
            ratios.append(errors[-1] / variance)
            shares.append(np.log(walk.share))
    return float(np.mean(ratios)), float(np.mean(errors)), float(np.mean(shares))


@pytest.mark.slow
@pytest.mark.parametrize("true_share", [0.2, 1.0, 6.0])
def test_a_filter_that_learns_how_far_its_state_walks_is_calibrated(true_share: float) -> None:
    """Where it walks less than assumed, as assumed, and further: four seeds each."""
    learnt = np.array([filtered(true_share, seed) for seed in range(4)])
    assert 0.75 < learnt[:, 0].mean() < 1.35
    assert abs(learnt[:, 2].mean() - np.log(true_share)) < 0.5


def test_a_state_that_stands_still_is_better_known() -> None:
    """The share falls to its bound; what is stated is still too much, for it is a walk's, but half of what it was."""
    learnt = np.array([filtered(0.0, seed) for seed in range(4)]).mean(axis=0)
    assumed = np.array([filtered(0.0, seed, learn=False) for seed in range(4)]).mean(axis=0)
    assert learnt[2] < np.log(0.15)
    assert learnt[1] < 0.6 * assumed[1]
    assert 0.4 < learnt[0] < 1.0


def test_a_filter_that_does_not_learn_is_not_calibrated() -> None:
    """What the tests above would find: too sure of itself where the state walks further."""
    assert filtered(6.0, 1, learn=False)[0] > 1.7


def test_what_was_not_measured_teaches_nothing() -> None:
    """Its variance has grown by all that was assumed."""
    walk = LearntWalk()
    for k in range(20):
        walk.see(0.0, 1.0 + k, 1.0)
    assert walk.share == 1.0


def test_the_share_stays_within_bounds() -> None:
    """A fifth and thirty times the deviation, however still or wild the estimate."""
    still, wild = LearntWalk(), LearntWalk()
    for k in range(60):
        still.see(0.0, 1.0, 1.0)
        wild.see(100.0 * (k % 2), 1.0, 1.0)
    assert still.share == 0.04
    assert wild.share == 900.0


def test_an_estimate_that_something_else_has_moved_teaches_nothing() -> None:
    """As when frequencies are loosened for a payload: the stretch is given up."""
    model = model_for(AMPLITUDE, 0.3)
    at = Layout(model, 2.0)
    noise = np.full((FILTERS, at.size), 1e-4)
    bank = FilterBank(at, np.full((FILTERS, at.size), 1e-4), np.zeros(FILTERS))
    walks = LearntWalks(at, noise, LAWS)
    for k in range(1, 20):
        bank.edge_s = 2.0 * k
        bank.x[:, at.frequency] = float(k % 2)
        loosen(bank)
        bank.p[:] = np.eye(at.size) * 1e-4
        walks.see(bank, Law.CLOCK, 0.0)
    assert np.all(noise == 1e-4)
    for k in range(20, 30):
        bank.edge_s = 2.0 * k
        bank.x[:, at.frequency] = float(k % 2)
        walks.see(bank, Law.CLOCK, 0.0)
    assert np.all(noise[:LAWS, at.frequency] > 2e-4)
    assert np.all(noise[LAWS:] == 1e-4)


def test_how_often_the_arm_is_disturbed_is_learnt() -> None:
    """The disturbed level is expected less where it explains the images worse, and again where it does better."""
    model = model_for(AMPLITUDE, 0.3)
    evidence = Evidence(model, Settings().fused, Layout(model, 2.0), 2.0)
    better = np.repeat(np.array((1.0, 1.05)), LAWS)
    nis = np.ones(FILTERS)
    first = float(evidence.weights[LAWS:].sum())
    for _ in range(1200):
        evidence.weigh(nis, better)
        evidence.remember()
    quiet = float(evidence.weights[LAWS:].sum())
    for _ in range(2400):
        evidence.weigh(nis, better[::-1])
        evidence.remember()
    disturbed = float(evidence.weights[LAWS:].sum())
    assert first == pytest.approx(0.2)
    assert quiet < 0.01
    assert disturbed > 0.7


SETTINGS = msgspec.structs.replace(Settings().fused, frequency_walk=0.00005)


def walking(seed: int, share_per_root_s: float) -> FusedMethod:
    """The method after 20 s of an arm struck now and then, whose frequency walks by that share."""
    model = model_for(AMPLITUDE, 0.3)
    random = np.random.default_rng(seed)
    steps = np.cumsum(share_per_root_s * np.sqrt(0.05) * random.standard_normal(2000))
    trial = ring(model, seed, 20.0, delay="drift", frequency=lambda t: 1.0 + float(steps[int(t / 0.05)]))
    method = FusedMethod(model, SETTINGS, "model")
    judge(method, model, trial)
    return method


@pytest.mark.slow
def test_the_method_learns_how_far_the_frequency_walks() -> None:
    """Less than it allows for where it is constant, more where it walks five times as far."""
    assumed = (SETTINGS.frequency_walk * 2.0 * np.pi * 2.6) ** 2
    still, restless = (
        float(walking(3, walk).frames.state.state_noise[0, 2]) / assumed for walk in (0.0, 0.0005)
    )
    assert still < 0.7
    assert restless > 1.5


def test_without_an_accelerometer_walks_are_as_assumed_or_as_far_as_was_learnt() -> None:
    at = Layout(model_for(AMPLITUDE, 0.3), 2.0)
    noise = np.full((FILTERS, at.size), 0.01)
    walks = LearntWalks(at, noise, LAWS)
    places = range(at.frequency.start, at.decay.stop)
    for walk, share in zip(walks._walks, (0.04, 9.0), strict=True):
        walk.share = share
        noise[:LAWS, places] *= 0.1
    walks.allow_as_assumed()
    kept = np.full((FILTERS, at.size), 0.01)
    kept[:LAWS, at.decay.start] *= 9.0
    assert noise == pytest.approx(kept)


def test_an_impact_that_images_alone_show_leaves_what_delay_and_frequency_have_in_common() -> None:
    """And all else that is no vibration is what it was before it, to the laws that let the delay walk."""
    at = Layout(model_for(AMPLITUDE, 0.3), 2.0)
    bank = FilterBank(at, np.full((FILTERS, at.size), 1e-4), np.zeros(FILTERS))
    w, t = at.frequency.start, at.shift
    bank.p[:, w, t] = bank.p[:, t, w] = 6e-5
    bank.p[:, 0, t] = bank.p[:, t, 0] = 3e-5
    x, p = bank.x.copy(), bank.p.copy()
    bank.x += 0.01
    bank.p *= 0.5
    now = bank.p.copy()
    grown = np.zeros((FILTERS, at.size))
    grown[:, t] = 2e-5
    forget_phase(bank, 0.02, x, p, grown)
    drift, clock = int(Law.DRIFT), int(Law.CLOCK)
    assert bank.p[drift, w, t] == bank.p[drift, t, w] == 6e-5
    assert bank.p[drift, t, t] == pytest.approx(1.2e-4)
    assert bank.x[drift, at.phasor.stop :] == pytest.approx(0.0)
    assert bank.p[clock, at.phasor.stop :, at.phasor.stop :] == pytest.approx(
        now[clock, at.phasor.stop :, at.phasor.stop :]
    )
    assert bank.x[clock, t] == 0.01
    for law in (drift, clock):
        assert not bank.p[law, at.phasor, at.phasor.stop :].any()
        assert np.diag(bank.p[law])[at.phasor] == pytest.approx(0.02**2)
        assert np.linalg.eigvalsh(bank.p[law]).min() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("wander_s", [1.0, 8.0])
def test_the_method_learns_how_fast_the_delay_wanders(wander_s: float) -> None:
    """The rate at which it comes back to its mean, where no clock dates the frames; the spread is the model's."""
    model = model_for(AMPLITUDE, 0.3)
    trial = ring(model, 5, 25.0, delay="drift", triggered=True, wander_s=wander_s)
    method = FusedMethod(model, Settings().fused, "model")
    judge(method, model, trial)
    assumed = float(start.shift_return()[Law.DRIFT])
    learnt = float(method.frames.dates.shift_noise[Law.DRIFT] / start.shift_noise(model)[Law.DRIFT])
    assert 1.0 / 1.6 < learnt * assumed * wander_s < 1.6


@pytest.mark.parametrize(("own", "stretch_s"), [(Law.DRIFT, 0.25), (Law.STEADY, 1.5)])
def test_a_wander_is_learnt_in_stretches_that_its_law_was_believed_throughout(
    own: Law, stretch_s: float
) -> None:
    at = Layout(model_for(AMPLITUDE, 0.3), 2.0)
    bank = FilterBank(at, np.full((FILTERS, at.size), 1e-6), np.zeros(FILTERS))
    noise, back = np.full(FILTERS, 4e-6), np.full(FILTERS, 0.35)
    wander = LearntWander(at, own, noise, back)

    def strides(law: Law, step_s: float) -> float:
        """The share after twenty stretches of it, in each of which the shift went three deviations."""
        for k in range(20):
            bank.edge_s += step_s
            bank.x[:, at.shift] = 3.0 * (4e-6 * stretch_s) ** 0.5 * (k % 2)
            wander.see(bank, law)
        return wander.share

    assert strides(Law.CLOCK, stretch_s) == 1.0
    assert strides(own, 2.4 * stretch_s) == 1.0  # images were missing, or the arm was still
    assert strides(own, stretch_s) > 5.0
    for assumed, now in ((4e-6, noise), (0.35, back)):
        assert now[own::LAWS] == pytest.approx(wander.share * assumed)
        assert np.all(np.delete(now, [own, LAWS + own]) == assumed)
