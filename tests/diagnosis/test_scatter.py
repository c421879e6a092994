"""Laws of what is left beside its mean."""

from dataclasses import replace

import msgspec
import numpy as np

from stillarm.diagnosis.fit import make_data
from stillarm.diagnosis.scatter import ON_ITS_PAST, uneven
from stillarm.diagnosis.split import interleaved
from tests.fixtures.synthetic import MODEL, fitted, measured

SPLIT = interleaved(9.0)
STEP_RAD = 2.0 * np.pi / 2.0**14


def test_rounding_that_stays_while_the_joint_stands_is_no_memory() -> None:
    data = measured(9.0, 3)
    clean = fitted(data, split=SPLIT).predicted.channels["joint_position"]
    quiet = clean + np.random.default_rng(5).normal(0.0, 8e-5, len(clean))
    rounded = replace(data, position=np.round(quiet / STEP_RAD) * STEP_RAD)
    swaying = replace(data, position=quiet + 5e-4 * np.sin(np.arange(len(clean)) * 0.01))
    for changed, remembers in ((rounded, False), (swaying, True)):
        last = fitted(changed, split=SPLIT)
        laws = {(one.channel, one.law) for one in uneven(make_data(last.world, SPLIT), last)}
        assert (("joint_position", ON_ITS_PAST) in laws) is remembers


def test_a_sensor_that_scatters_less_at_the_limit_of_its_range_is_no_uneven_scatter() -> None:
    data = measured(9.0, 3)
    limit = 0.4 * float(np.nanmax(np.abs(data.acceleration)))
    sensor = msgspec.structs.replace(MODEL.accelerometer, range_m_s2=limit)
    model = msgspec.structs.replace(MODEL, accelerometer=sensor)
    last = fitted(
        replace(data, acceleration=np.clip(data.acceleration, -limit, limit)), model=model, split=SPLIT
    )
    at_limit = np.abs(last.world.channels["acceleration"]) >= limit
    assert at_limit.sum() > 100
    laws = [one for one in uneven(make_data(last.world, SPLIT), last) if one.channel == "acceleration"]
    assert max(one.train_log_likelihood for one in laws if one.law.startswith("the scatter")) < 12.0
