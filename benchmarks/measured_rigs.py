"""The measured sets of ../shared/data as the diagnosis of driven joints reads them (docs/measured-rigs.md)."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from stillarm.benchmarks.identification_data import Pair, f16, robot_arm, silverbox
from stillarm.benchmarks.identification_driven import read_pair
from stillarm.common.recording.reader import open_recording
from stillarm.diagnosis.driven.recording.signals import Driven, read_driven
from stillarm.tables.description import parse_description
from stillarm.tables.importing import import_tables
from stillarm.tables.readers.read_file import read_table_file

QUANSER_FILE = Path("quanser_flexible_link") / "lqr_full_10deg.mat"
QUANSER = """
source = "lqr_full_10deg.mat"
[[tables]]
name = "10000 rows"
time_column = "data_Im1(:,1)"
time_unit = "s"
[[tables.channels]]
column = "data_Im1(:,3)"
role = "motor_current_a"
unit = "A"
[[tables.channels]]
column = "data_th11(:,3)"
role = "joint_position_rad"
unit = "deg"
[[tables.channels]]
column = "data_th12(:,3)"
role = "strain"
unit = "unknown"
"""
"""Import description of the first stage: measured current, joint angle, deflection by strain."""


def quanser(folder: Path) -> Driven | None:
    """The first stage of the two-stage flexible link; None without the data."""
    file = folder / QUANSER_FILE
    if not file.is_file():
        return None
    with tempfile.TemporaryDirectory() as scratch:
        recording = Path(scratch) / "quanser.mcap"
        import_tables(read_table_file(file), parse_description(QUANSER, "description"), QUANSER, recording)
        return read_driven(open_recording(recording))


def _fitted_of(read: Callable[[Path], Pair | None]) -> Callable[[Path], Driven | None]:
    """The samples of a pair that are fitted."""

    def driven(folder: Path) -> Driven | None:
        pair = read(folder)
        return None if pair is None else read_pair(pair, pair.train)

    return driven


SETS: dict[str, Callable[[Path], Driven | None]] = {
    "quanser": quanser,
    "silverbox": _fitted_of(silverbox),
    "robot_arm": _fitted_of(robot_arm),
    "f16_vibration": _fitted_of(f16),
}
"""By name, what reads a set from the folder of the measured data; None where that lacks it."""
