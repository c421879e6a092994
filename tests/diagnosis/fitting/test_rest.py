"""What is left in a channel, and when it matters."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.channel_noise import noise_of
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.rest import (
    anything_but_spikes_matters,
    anything_matters,
    explainable,
    rest_of,
    times_what_matters,
)
from stillarm.diagnosis.physics.space import Added
from tests.fixtures.synthetic import NOISE, fitted, measured

SPLIT = interleaved(20.0)


@pytest.fixture(scope="module")
def arm() -> Fit:
    return fitted(measured(20.0, 3))


def test_what_is_at_the_noise_is_no_rest(arm: Fit) -> None:
    for name in arm.residuals:
        assert rest_of(arm, name, SPLIT).immaterial, name


def test_a_rest_as_large_as_the_noise_matters(arm: Fit) -> None:
    name = "displacement"
    noise = noise_of(arm, name, SPLIT)
    time = arm.world.measured.frames.received_s
    slow = 3.0 * noise * np.sin(2.0 * np.pi * 1.3 * time)
    worse = replace(arm, residuals={**arm.residuals, name: arm.residuals[name] + slow})
    rest = rest_of(worse, name, SPLIT)
    assert rest.rms == pytest.approx(3.0 * noise / np.sqrt(2.0), rel=0.15)
    assert not rest.immaterial
    assert rest.band_hz[0] < 1.4 and rest.band_hz[1] > 1.2


def test_a_rest_is_told_in_times_what_matters(arm: Fit) -> None:
    """The largest of half the noise, a two-thousandth of the motion and 0.02 px."""
    name = "displacement"
    noise = noise_of(arm, name, SPLIT)
    slow = 3.0 * noise * np.sin(2.0 * np.pi * 1.3 * arm.world.measured.frames.received_s)
    worse = replace(arm, residuals={**arm.residuals, name: arm.residuals[name] + slow})
    matters = max(0.5 * noise, float(np.nanstd(arm.world.channels[name])) / 2000.0, 0.02)
    assert times_what_matters(worse, name, SPLIT) == pytest.approx(
        3.0 * noise / np.sqrt(2.0) / matters, rel=0.15
    )
    assert times_what_matters(arm, name, SPLIT) < 1.0


@pytest.mark.parametrize(("walks", "immaterial"), [(True, True), (False, False)])
def test_where_a_walk_went_while_it_was_held_out_is_no_rest(arm: Fit, walks: bool, immaterial: bool) -> None:
    """Nobody foretells that; of any other course it tells how well it is known."""
    name, time = "displacement", arm.world.times_of("displacement")
    held = SPLIT.held[SPLIT.blocks_of(time)]
    strayed = np.where(held, 5.0 * noise_of(arm, name, SPLIT), 0.0)
    course = Added("strayed", {name: time[:, None]}, 1.0, over_time=True, walks=walks)
    world = arm.world.changed(added=(course,))
    walked = replace(
        arm,
        world=world,
        residuals={**arm.residuals, name: arm.residuals[name] + strayed[: len(arm.residuals[name])]},
    )
    assert rest_of(walked, name, SPLIT).immaterial is immaterial


def test_lone_spikes_are_nothing_that_a_model_could_explain(arm: Fit) -> None:
    name = "acceleration"
    off = arm.residuals[name].copy()
    off[500::997] += 40.0 * noise_of(arm, name, SPLIT)
    spiked = replace(arm, residuals={**arm.residuals, name: off})
    assert explainable(spiked, SPLIT)[name] < 10.0
    assert not anything_but_spikes_matters(spiked, SPLIT)
    lasting = off.copy()
    for after in range(1, 8):
        lasting[500 + after :: 997] += 40.0 * noise_of(arm, name, SPLIT)
    lasts = replace(arm, residuals={**arm.residuals, name: lasting})
    assert explainable(lasts, SPLIT)[name] > 100.0


def test_a_spike_that_reaches_the_sensors_limit_is_a_lone_one_too() -> None:
    """Not what reads the limit where the simulation is there as well."""
    name, data = "acceleration", measured(20.0, 3)
    limit = 0.7 * float(np.max(np.abs(data.acceleration)))
    read = np.clip(data.acceleration, -limit, limit)
    fit = fitted(replace(data, acceleration=read))
    shown = np.clip(fit.predicted.channels[name], -limit, limit)
    quiet = np.flatnonzero(np.abs(shown) < 0.2 * limit)[::200]
    read[quiet] = limit
    spiked = fitted(replace(data, acceleration=read))
    predicted = replace(fit.predicted, channels={**fit.predicted.channels, name: shown})
    left = replace(spiked, residuals={**fit.residuals, name: read - shown}, predicted=predicted)
    assert (read >= limit).mean() > 0.01  # it reads its limit often
    assert anything_matters(left, SPLIT) and not anything_but_spikes_matters(left, SPLIT)


def test_spikes_matter_to_whom_no_law_has_told_them(arm: Fit) -> None:
    name = "acceleration"
    off = arm.residuals[name].copy()
    off[500::97] += 40.0 * noise_of(arm, name, SPLIT)
    spiked = replace(arm, residuals={**arm.residuals, name: off})
    assert anything_matters(spiked, SPLIT) and not anything_but_spikes_matters(spiked, SPLIT)


def test_a_sensor_at_its_limit_has_no_spikes_beside_it() -> None:
    """A soft limit: two samples of three are foretold at it and have a tenth of the noise, which the others exceed."""
    data = measured(6.0, 1)
    limit = float(np.quantile(np.abs(data.acceleration), 0.33))
    fit = fitted(data)
    shown = np.clip(fit.predicted.channels["acceleration"], -limit, limit)
    limited = np.abs(shown) >= limit
    noise = np.random.default_rng(3).normal(0.0, NOISE["acceleration"], data.cycles)
    residuals = {**fit.residuals, "acceleration": np.where(limited, 0.1 * noise, noise)}
    predicted = replace(fit.predicted, channels={**fit.predicted.channels, "acceleration": shown})
    left = replace(fit, residuals=residuals, predicted=predicted)
    assert explainable(left, interleaved(6.0))["acceleration"] == 0.0
