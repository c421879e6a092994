"""A jump of the vibration is found about a mode's frequency; where nothing jumps, none."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from stillarm.common.files.model import Mode
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impacts import fit_with_impacts, with_further_impacts
from stillarm.diagnosis.events.jumps import find_jumps
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from tests.diagnosis.events.test_impacts import impact
from tests.fixtures.synthetic import MODEL, fitted, measured


def test_a_jump_is_found_within_a_part_of_a_swing_and_where_nothing_jumps_none() -> None:
    plain = fitted(measured(10.0, 3))
    assert find_jumps(plain, 0.5) == []
    struck = World(measured(10.0, 3, impact(1, 0.01), impacts=(4300,)), MODEL)
    last = fit(make_data(struck, interleaved(10.0)), plain.vector, (), iterations=0)
    assert find_jumps(last, 0.5) == pytest.approx([4.3], abs=0.1)


@pytest.mark.slow
def test_an_impact_that_a_higher_mode_alone_shows_is_found_while_the_joint_rests() -> None:
    """An arm that rubs may hold its first mode where it is struck."""
    modes = [*MODEL.arm.modes, Mode(frequency_hz=16.0, damping_ratio=0.004, participation=-0.3)]
    model = msgspec.structs.replace(MODEL, arm=msgspec.structs.replace(MODEL.arm, modes=modes))
    for cycle, seen in ((5600, True), (1500, False)):
        data = measured(10.0, 3, {"jump.1.1.v": 0.2}, impacts=(cycle,), model=model)
        assert data.rests_about(cycle, 400) is seen
        found = fit_with_impacts(World(data, model), interleaved(10.0)).world.impacts
        assert not seen or (len(found) == 1 and abs(found[0] - cycle) <= 60)


@pytest.mark.parametrize("factor", [-1.6, 2.7])
def test_a_jump_that_both_sensors_show_plainly_is_found_whatever_the_scale_of_one(factor: float) -> None:
    """A camera that turns with the tip sees its bending enlarged, or the other way round."""
    data = measured(10.0, 3, impact(1, 0.01), impacts=(4300,))
    camera = msgspec.structs.replace(MODEL.camera, scale_px_per_m=factor * MODEL.camera.scale_px_per_m)
    struck = World(data, msgspec.structs.replace(MODEL, camera=camera))
    last = fit(make_data(struck, interleaved(10.0)), struck.space.vector(), (), iterations=0)
    assert 4.3 in [pytest.approx(one, abs=0.1) for one in find_jumps(last, 0.5)]


def test_a_strong_push_hides_no_lesser_impact_once_its_own_is_known() -> None:
    """It bends the arm by its force while it lasts: no state after it accounts for that."""
    pushed, struck = 2800, 7400
    data = measured(10.0, 3, {**impact(1, 0.02), **impact(2, 0.003)}, impacts=(pushed, struck))
    lasting = np.abs(np.arange(data.cycles) - pushed) < 60
    shaken = data.acceleration + np.where(lasting, 30.0, 0.0)
    unseen = replace(data.frames, displacement_px=np.full(len(data.frames.displacement_px), np.nan))
    data = replace(data, acceleration=shaken, frames=unseen)
    world, split = World(data, MODEL, (pushed,)), interleaved(10.0)
    vector = world.space.with_values(world.space.vector(), {"jump.0.0.q": 0.02, **impact(1, 0.02)})
    last = fit(make_data(world, split), vector, (), iterations=0)
    assert all(abs(one - 0.001 * pushed) < 0.5 for one in find_jumps(last, 0.25))
    assert find_jumps(last, 0.25, elsewhere=True) == pytest.approx([0.001 * struck], abs=0.1)
    found = with_further_impacts(last, split).world.impacts
    assert any(abs(one - struck) < 60 for one in found)
