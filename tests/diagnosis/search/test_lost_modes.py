"""Higher modes that a fit has lost are begun again."""

import msgspec
import pytest

from stillarm.common.files.model import Mode
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.baseline import lost_modes, with_lost_modes
from tests.fixtures.synthetic import MODEL, fitted, measured

SPLIT = interleaved(8.0)
TWO = msgspec.structs.replace(
    MODEL,
    arm=msgspec.structs.replace(
        MODEL.arm, modes=[*MODEL.arm.modes, Mode(frequency_hz=14.0, damping_ratio=0.01, participation=-0.3)]
    ),
)


@pytest.mark.slow
def test_a_mode_that_was_lost_is_found_from_where_the_model_has_it() -> None:
    data = measured(8.0, 3, {"modes.1.frequency_hz": 14.1}, model=TWO)
    world = World(data, TWO)
    start = world.space.vector()
    start[world.space.place["modes.1.frequency_hz"]] = 6.0
    start[world.space.place["modes.1.participation"]] = 0.0
    stuck = fit(make_data(world, SPLIT), start, world.baseline_names(), iterations=0)
    assert lost_modes(stuck) == [1]
    found = with_lost_modes(stuck, SPLIT)
    assert found.train_log_likelihood > stuck.train_log_likelihood + 100.0
    assert found.value("modes.1.frequency_hz") == pytest.approx(14.1, rel=1e-3)
    assert found.value("modes.1.participation") == pytest.approx(-0.3, rel=0.05)


def test_a_fit_that_has_its_modes_stays_as_it_is() -> None:
    found = fitted(measured(8.0, 4, model=TWO), model=TWO, split=SPLIT)
    assert with_lost_modes(found, SPLIT) is found
