"""Terms without a name."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.anonymous import explained
from stillarm.diagnosis.fit import make_data
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

SPLIT = interleaved(9.0)


@pytest.mark.parametrize(("strays_rad", "told"), [(3e-5, False), (1e-3, True)])
def test_a_joint_that_strays_by_less_than_a_simulation_reaches_is_no_discovery(
    strays_rad: float, told: bool
) -> None:
    data = measured(9.0, 3)
    clean = fitted(data, split=SPLIT).predicted.channels["joint_position"]
    time = np.linspace(-0.5, 0.5, len(clean))
    quiet = clean + np.random.default_rng(5).normal(0.0, 1e-4, len(clean)) + strays_rad * time
    last = fitted(replace(data, position=quiet), split=SPLIT)
    terms = explained(make_data(last.world, SPLIT), last)
    assert (terms.channel == "joint_position") is told


def loose(tip_acceleration: NDArray[np.float64], hertz: float, hold: float) -> NDArray[np.float64]:
    """What a mount does that friction holds up to `hold` deviations of what shakes it: largest value 1."""
    limit = hold * float(np.std(tip_acceleration))
    free = tip_acceleration - np.clip(tip_acceleration, -limit, limit)
    pole = np.exp(2.0 * np.pi * hertz * 0.001 * (-0.1 + 1j))
    rattle = lfilter([0.0, 1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], free)
    return np.asarray(rattle / np.max(np.abs(rattle)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("is_loose", "hertz", "hold"), [(True, 9.3, 1.4), (True, 6.1, 0.7), (False, 0.0, 0.0)]
)
def test_a_mount_that_comes_loose_is_told_from_a_tilt(is_loose: bool, hertz: float, hold: float) -> None:
    """Frequency, damping and hold lie beside those of any term."""
    data = measured(20.0, 3, {} if is_loose else {"camera.rotation_px_per_rad": 30.0}, (9000, 14000))
    split = interleaved(20.0)
    world = World(data, MODEL, (9000, 14000))
    if is_loose:
        motion = world.predict(world.space.vector()).motion
        instants = world.instants(world.space.vector())
        shaken = np.interp(instants, world.cycle_times, loose(motion.tip_acceleration, hertz, hold))
        frames = replace(data.frames, displacement_px=data.frames.displacement_px + 0.4 * shaken)
        data = replace(data, frames=frames)
    baseline, tilted = fitted(data, split=split), fitted(data, "camera.rotation_px_per_rad", split=split)
    terms = explained(make_data(baseline.world, split), baseline)
    assert terms.channel == "displacement"
    ahead = terms.first_nats - (tilted.train_log_likelihood - baseline.train_log_likelihood)
    assert (ahead > 5.0) is is_loose
    assert terms.names[0].startswith("a mount") or not is_loose
