"""`stillarm.replay`: the same numbers as the command's, and a method of one's own without a package."""

from pathlib import Path

import numpy as np
import pytest

import stillarm
from stillarm.controller.estimation.delay.constant import ConstantDelay

pytestmark = pytest.mark.slow


def test_methods_by_name_and_of_ones_own(short_recording: Path) -> None:
    told: list[tuple[float, str]] = []
    own = stillarm.with_sine_prediction(ConstantDelay)
    found = stillarm.replay(short_recording, "timestamps", progress=lambda *one: told.append(one))
    found |= stillarm.replay(short_recording, {"mine": own})
    assert list(found) == ["timestamps", "mine"]
    assert told[-1] == (1.0, "") and all(0.0 <= done <= 1.0 for done, _ in told)
    channels = stillarm.load(short_recording)
    for one in found.values():
        assert np.array_equal(one.estimates["time_s"], channels.fast["time_s"])
        assert np.array_equal(one.frames["frame"], channels.frames["frame"])
    assert set(found["mine"].frames["delay_s"]) == {channels.model.timing.capture_delay_s}
    live = stillarm.replay(short_recording, "fused")["fused"].estimates["deflection_m"]
    assert live == pytest.approx(channels["estimate"]["deflection_m"], nan_ok=True)


def test_a_mistake_is_one_line(short_recording: Path) -> None:
    with pytest.raises(stillarm.UserError, match="fused"):
        stillarm.replay(short_recording, ["fsed"])
    with pytest.raises(stillarm.UserError, match="nothing to replay"):
        stillarm.replay(short_recording.with_name("truth.mcap"))
