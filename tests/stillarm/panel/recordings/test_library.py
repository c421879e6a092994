"""A recording in the page: read by a process of its own, drawn without losing a peak, replayed."""

import asyncio
import struct
from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import EstimateSample, FastSample, LogLine
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError
from stillarm.panel.recordings.extract import extract
from stillarm.panel.recordings.library import Library
from stillarm.panel.recordings.replayed import convert

ROWS, SPIKE = 5000, 3210


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "recordings"
    folder.mkdir()
    header = RecordingHeader(
        program_version="1", configuration="", configuration_name="", model="", method="fused", kind="live"
    )
    writer = RecordingWriter(folder / "a.mcap", header)
    for cycle in range(ROWS):
        acceleration = 9.0 if cycle == SPIKE else 0.0
        writer.write("/fast", FastSample(cycle * 1e-3, cycle, acceleration))
        state = "armed" if cycle < 2000 else "damping"
        estimate = EstimateSample(
            cycle * 1e-3, cycle, 0.07, 0.001, "estimated", 0.01, 0.0, 0.01, 0.0, "", state
        )
        writer.write("/estimate", estimate)
    writer.write("/log", LogLine(2.0, "info", "damping"))
    writer.close()
    return folder


def columns(message: bytes) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    _, count, rows = struct.unpack_from("<BBH", message)
    times = np.frombuffer(message, "<f8", rows, 8)
    return times, np.frombuffer(message, "<f4", rows * count, 8 + 8 * rows).reshape(count, rows)


def test_what_is_extracted_is_what_was_recorded(folder: Path, tmp_path: Path) -> None:
    extract(folder / "a.mcap", tmp_path / "out")
    fast = np.load(tmp_path / "out" / "fast.npy")
    assert fast.shape[1] == ROWS and fast[1, SPIKE] == 9.0 and fast[0, -1] == pytest.approx(4.999)


@pytest.mark.slow
def test_a_recording_is_opened_and_drawn_in_any_width(folder: Path, tmp_path: Path) -> None:
    async def run() -> None:
        library = Library(folder, tmp_path / "cache")
        key = await library.open("a.mcap")
        about = library.about(key)
        assert about["topics"].keys() == {"fast", "estimate"} and about["methods"] == []
        assert about["changes"] == [[0.0, "armed", ""], [2.0, "damping", ""]]
        assert about["lines"][0]["text"] == "damping"
        times, whole = columns(library.series(key, "fast", 0.0, 10.0, 10_000))
        assert len(times) == ROWS
        times, thin = columns(library.series(key, "fast", 0.0, 10.0, 50))
        assert len(times) == 100 and thin[0].max() == whole[0].max() == 9.0
        times, _ = columns(library.series(key, "fast", 1.0, 2.0, 10_000))
        assert (times[0], len(times)) == (1.0, 1000)
        for topic in ("none", "../a", "replay_fused"):
            with pytest.raises(UserError, match="open it again"):
                library.series(key, topic, 0.0, 1.0, 10)
        with (folder / "a.mcap").open("ab") as file:
            file.write(b"more")  # it grows: what is open stays as it was
        assert library.about(key)["key"] == key
        with pytest.raises(UserError, match="not been diagnosed"):
            library.report(key)
        with pytest.raises(UserError, match="not open"):
            library.about("0" * 24)
        await library.close()

    asyncio.run(run())


def test_a_replays_tables_become_columns(tmp_path: Path) -> None:
    (tmp_path / "estimates.csv").write_text(
        "time_s,method,status,deflection_m,deflection_std_m\n"
        "0.001,fused,estimated,0.5,0.1\n0.002,fused,estimated,0.6,\n0.001,timestamps,estimated,0.4,\n"
    )
    (tmp_path / "frames.csv").write_text(
        "frame,received_s,method,status,delay_s,delay_std_s\n1,0.002,fused,estimated,0.07,0.001\n"
    )
    assert convert(tmp_path) == ["fused", "timestamps"]
    fused = np.load(tmp_path / "replay_fused.npy")
    assert fused[1].tolist() == [0.5, 0.6] and np.isnan(fused[2, 1])
    assert np.isnan(fused[3, 0]) and fused[3, 1] == 0.07  # the delay of the newest image
    assert np.isnan(np.load(tmp_path / "replay_timestamps.npy")[3]).all()
