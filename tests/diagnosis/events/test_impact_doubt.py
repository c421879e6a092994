"""An impact is as sure as the noise about the arm's frequency allows, whatever else a sensor shows."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impact_doubt import doubts_about_modes, level_about, sizes_in_stds
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from tests.diagnosis.events.test_impacts import impact
from tests.fixtures.synthetic import MODEL, measured

N, STEP_S, HZ = 3000, 1.0 / 65.0, 2.6
TIME = np.arange(N) * STEP_S


def test_white_noise_has_its_level_at_every_frequency() -> None:
    white = np.random.default_rng(1).normal(0.0, 0.4, N)
    for hz in (1.0, HZ, 20.0, 40.0):  # the last is faster than half the sampling
        assert level_about(white, hz, STEP_S) == pytest.approx(0.4, rel=0.15)
    white[500:700] = np.nan
    assert level_about(white, HZ, STEP_S) == pytest.approx(0.4, rel=0.15)


def test_a_drift_and_a_hum_are_elsewhere() -> None:
    white = np.random.default_rng(2).normal(0.0, 0.4, N)
    more = 3.0 * np.sin(2.0 * np.pi * TIME / TIME[-1]) + 2.0 * np.sin(2.0 * np.pi * 20.0 * TIME)
    assert level_about(white + more, HZ, STEP_S) == pytest.approx(0.4, rel=0.2)


def test_what_is_about_the_mode_counts() -> None:
    white = np.random.default_rng(3).normal(0.0, 0.4, N)
    assert level_about(white + np.sin(2.0 * np.pi * HZ * TIME), HZ, STEP_S) > 1.0


def test_a_drift_of_the_images_makes_no_impact_doubtful() -> None:
    data = measured(9.0, 3, impact(1, 0.004), impacts=(4300,))
    seen = data.frames.displacement_px
    drift = 5.0 * np.linspace(-1.0, 1.0, len(seen)) ** 2
    images = replace(data, acceleration=np.full(data.cycles, np.nan))
    sizes = []
    for frames in (images.frames, replace(images.frames, displacement_px=seen + drift)):
        world = World(replace(images, frames=frames), MODEL, impacts=(4300,))
        last = fit(make_data(world, interleaved(9.0)), world.space.vector(), world.baseline_names())
        sizes += sizes_in_stds(last, doubts_about_modes(last))
    assert sizes[0] > 6.0
    assert sizes[1] > 6.0
