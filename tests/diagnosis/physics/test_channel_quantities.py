"""A channel's own quantities: a prediction beside another one shows the same as one by itself, whatever differs."""

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from stillarm.common.files.model import Mode
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, empty

Array = NDArray[np.float64]

SECONDS = 3.0
BOTH = replace(MODEL, arm=replace(MODEL.arm, modes=[Mode(), Mode(frequency_hz=15.0, participation=-0.2)]))
AT_WORK = {
    "jump.0.0.q": 0.02,
    "jump.1.0.v": 0.1,
    "arm.cubic_per_m2": 50.0,
    "drive.velocity_loss_rad_s": 0.01,
    "accelerometer.rate_m_s3": 0.02,
    "accelerometer.gravity_m_s2_per_rad": 0.3,
    "camera.rate_px_per_s": 0.5,
    "camera.rotation_px_per_rad": 20.0,
    "free.heating.0": 0.2,
}


def world_with_terms() -> World:
    """Two modes, an impact, a term without a formula in two channels."""
    measured = empty(SECONDS, BOTH)
    plain = World(measured, BOTH, (1500,))
    columns = {
        name: np.linspace(0.0, 1.0, len(plain.channels[name]))[:, None]
        for name in ("acceleration", "joint_position")
    }
    return plain.changed(added=(Added("free.heating", columns, 1.0),))


@pytest.mark.slow
def test_a_prediction_beside_another_is_the_same() -> None:
    world = world_with_terms()
    vector = world.space.with_values(world.space.vector(), AT_WORK)
    near = world.predict(vector)
    for name, place in world.space.place.items():
        quantity = world.space[name]
        moved = vector.copy()
        moved[place] = np.clip(moved[place] + 100.0 * quantity.step, quantity.low, quantity.high)
        alone, beside = world.predict(moved), world.predict(moved, near)
        for channel, values in alone.channels.items():
            np.testing.assert_allclose(
                beside.channels[channel], values, rtol=1e-9, atol=1e-9, err_msg=f"{channel} by {name}"
            )
        np.testing.assert_allclose(beside.rate_px_s, alone.rate_px_s, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("accelerometer.bias_m_s2", {"acceleration"}),
        ("camera.scale_px_per_m", {"displacement"}),
        ("timing.capture_delay_s", {"displacement", "arrival"}),
        ("free.heating.0", {"acceleration", "joint_position"}),
        ("camera.lens_per_px2", {"displacement"}),
    ],
)
def test_what_shows_nothing_of_a_change_is_not_worked_out_again(name: str, changed: set[str]) -> None:
    world = world_with_terms()
    vector = world.space.with_values(world.space.vector(), AT_WORK)
    near = world.predict(vector)
    step = 10.0 * world.space[name].step
    beside = world.predict(
        world.space.with_values(vector, {name: vector[world.space.place[name]] + step}), near
    )
    anew = {channel for channel, values in beside.channels.items() if values is not near.channels[channel]}
    assert anew == changed & set(world.channels)
