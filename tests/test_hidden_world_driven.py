"""The world of driven joints beside the program: its files come in as their descriptions say, with the same numbers."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.main import main
from stillarm.tables.unscaled import unscaled_channels
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import DESCRIPTION, form_of, write_case
from tests.hidden_world.driven.written import columns

pytestmark = pytest.mark.slow

SI = {"deg": np.pi / 180.0, "deg/s": np.pi / 180.0, "rpm": np.pi / 30.0, "mm": 1e-3, "g": 9.80665}
SI |= dict.fromkeys(("rad", "rad/s", "m", "m/s2", "A", "V", "N m"), 1.0)
"""By definition of the units, not by the program's table."""


@pytest.mark.parametrize("seed", range(10))
def test_a_case_comes_in_with_the_numbers_that_were_recorded(seed: int, tmp_path: Path) -> None:
    case = make(seed, "none", longest_s=10.0)
    write_case(case, tmp_path)
    table, out = tmp_path / form_of(case).name, tmp_path / "recording.mcap"
    assert main(["import", str(table), "--as", str(tmp_path / DESCRIPTION), "-o", str(out)]) == 0
    recording = open_recording(out)
    fast = recording.columns("/fast")
    free = {channel.role: channel.values for channel in unscaled_channels(recording)}
    assert np.allclose(np.diff(fast["time_s"]), 1.0 / case.rig.rate_hz, atol=2e-6)
    for column in columns(case):
        if column.unit == "unknown" and column.role != "strain":
            values, wanted = free[column.role], column.values
        else:
            size = column.scale or SI.get(column.unit, 1.0)
            values, wanted = fast[column.role], column.values * size
        assert len(values) == case.rig.rows
        assert np.allclose(values, wanted, rtol=1e-6, atol=1e-6 * float(np.max(np.abs(wanted))))
