"""A recording whose configuration does not say controller.arm_at_start replays with what was done live."""

import io
from math import nan
from pathlib import Path

import pytest

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.topics import EstimateSample, FastSample
from stillarm.common.recording.writer import RecordingWriter
from stillarm.controller.replay.replay import read_run
from stillarm.controller.safety.table import Operator, State


def recording(path: Path, configuration: str, states: list[str], arm_at: int | None) -> Path:
    header = RecordingHeader(
        program_version="0",
        configuration=configuration,
        configuration_name="c",
        model="",
        method="fused",
        kind="live",
    )
    file = io.BytesIO()
    writer = RecordingWriter(file, header)
    for cycle, state in enumerate(states):
        operator = int(Operator.ARM) if cycle == arm_at else 0
        writer.write("/fast", FastSample(cycle * 0.001, cycle, operator=operator))
        writer.write(
            "/estimate",
            EstimateSample(cycle * 0.001, cycle, nan, nan, "", nan, nan, nan, 0.0, "", state=state),
        )
    writer.close()
    path.write_bytes(file.getvalue())
    return path


@pytest.mark.parametrize(
    ("states", "arm_at", "wanted"),
    [
        ([State.PREFLIGHT, State.ARMED], None, True),
        ([State.PREFLIGHT, State.DEGRADED, State.ARMED], None, True),
        ([State.PREFLIGHT, State.IDLE, State.IDLE], None, False),
        ([State.IDLE, State.ARMED, State.DAMPING], 1, False),
        ([State.ARMED, State.ARMED], 1, True),
        (["", ""], None, True),  # older than the states
    ],
)
def test_a_key_that_is_not_written_is_read_off_what_happened(
    tmp_path: Path, states: list[str], arm_at: int | None, wanted: bool
) -> None:
    """Its default was true in older programs."""
    path = recording(tmp_path / "a.mcap", "", states, arm_at)
    assert read_run(open_recording(path)).configuration.controller.arm_at_start is wanted


@pytest.mark.parametrize("written", [True, False])
def test_a_key_that_is_written_holds(tmp_path: Path, written: bool) -> None:
    text = f"[controller]\narm_at_start = {str(written).lower()}\n"
    path = recording(tmp_path / "a.mcap", text, [State.PREFLIGHT, State.ARMED], None)
    assert read_run(open_recording(path)).configuration.controller.arm_at_start is written
