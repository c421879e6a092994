"""Methods beside the one in force: on the telemetry of a run they say what a replay of its recording says."""

import struct
from collections import defaultdict
from io import BytesIO

import msgspec
import numpy as np
import pytest

from stillarm.common.files.configuration import Telemetry
from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.recorder.telemetry import TelemetryBatches
from stillarm.common.recording.reader import open_recording
from stillarm.controller.replay.replay import RecordedRun, read_run, replay_method
from stillarm.panel.live.beside import BESIDE_COLUMNS, FIRST_KIND, Beside
from stillarm.panel.live.beside_process import HEAD, LENGTH, TELEMETRY, WANTED, follow
from tests.fixtures.simulated import record

METHODS = ("timestamps", "correlation", "fused")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    scenario = Scenario(duration_s=3.0, strikes=[Strike(0.6, 0.02)])
    return read_run(open_recording(record(tmp_path_factory.mktemp("beside"), scenario=scenario, method=None)))


@pytest.fixture(scope="module")
def datagrams(run: RecordedRun) -> list[bytes]:
    """As the recorder's process sends them: each cycle's row, then the frames that it read."""
    batches, sent, frames = TelemetryBatches(Telemetry()), [], iter(run.frames)
    frame = next(frames, None)
    for row in run.fast:
        batches.take("/fast", row)
        sent += batches.due(row.time_s)  # so that a cycle's frames come with the next datagram
        while frame is not None and frame.cycle <= row.cycle:
            batches.take("/frames", frame)
            frame = next(frames, None)
    return sent + batches.due(np.inf)


def beside(run: RecordedRun) -> Beside:
    return Beside(run.model, run.configuration.controller, "model.toml", METHODS)


def unpacked(messages: list[bytes]) -> dict[str, np.ndarray]:
    """Times and columns of each method, (1 + columns, n)."""
    parts = defaultdict(list)
    for message in messages:
        kind, columns, rows = struct.unpack_from("<BBH", message)
        assert columns == len(BESIDE_COLUMNS)
        times = np.frombuffer(message, "<f8", rows, 8)
        values = np.frombuffer(message, "<f4", columns * rows, 8 + 8 * rows).reshape(columns, rows)
        parts[METHODS[kind - FIRST_KIND]].append(np.vstack([times, values]))
    return {method: np.hstack(some) for method, some in parts.items()}


def check_as_replayed(run: RecordedRun, method: str, got: np.ndarray) -> None:
    replayed = replay_method(run, method)
    assert got.shape[1] == len(replayed.times_s) - 1  # the newest cycle's frames may still come
    wanted = [
        (time, one.deflection_m, one.deflection_std_m, one.delay.delay_s, one.delay.std_s)
        for time, one in zip(replayed.times_s[:-1], replayed.estimates[:-1], strict=True)
    ]
    assert np.array_equal(got[0], [row[0] for row in wanted])
    assert np.array_equal(got[1:], np.array(wanted, dtype=np.float32).T[1:], equal_nan=True)


def test_each_says_what_a_replay_of_the_recording_says(run: RecordedRun, datagrams: list[bytes]) -> None:
    one = beside(run)
    one.want(["timestamps", "fused", "of no package"])
    got = unpacked([message for datagram in datagrams for message in one.take(datagram)])
    assert set(got) == {"timestamps", "fused"}
    for method, values in got.items():
        check_as_replayed(run, method, values)


def test_another_run_of_the_controller_begins_anew(run: RecordedRun, datagrams: list[bytes]) -> None:
    one = beside(run)
    one.want(["timestamps"])
    for datagram in datagrams:
        one.take(datagram)
    again = unpacked([message for datagram in datagrams for message in one.take(datagram)])
    check_as_replayed(run, "timestamps", again["timestamps"])


def test_what_is_no_longer_wanted_ends_and_what_stays_goes_on(
    run: RecordedRun, datagrams: list[bytes]
) -> None:
    one = beside(run)
    one.want(["timestamps", "correlation"])
    half = len(datagrams) // 2
    first = unpacked([message for datagram in datagrams[:half] for message in one.take(datagram)])
    one.want(["timestamps"])
    second = unpacked([message for datagram in datagrams[half:] for message in one.take(datagram)])
    assert set(first) == {"timestamps", "correlation"} and set(second) == {"timestamps"}
    check_as_replayed(run, "timestamps", np.hstack([first["timestamps"], second["timestamps"]]))
    one.want([])
    assert one.take(datagrams[-1]) == []


def test_what_is_no_telemetry_is_left_out(run: RecordedRun) -> None:
    one = beside(run)
    one.want(["timestamps"])
    encode = msgspec.msgpack.encode
    foreign = encode(
        [{"time_s": float(i), "fast": {"cycle": i, "of_another_version": 1.0}} for i in range(5)]
    )
    for datagram in (b"", b"\xff", encode({"a": 1}), encode([1, 2]), foreign):
        assert one.take(datagram) == []


def test_the_process_takes_blocks_and_gives_blocks(run: RecordedRun, datagrams: list[bytes]) -> None:
    def block(kind: int, content: bytes) -> bytes:
        return HEAD.pack(kind, len(content)) + content

    source = BytesIO(block(WANTED, b'["timestamps"]') + b"".join(block(TELEMETRY, one) for one in datagrams))
    out = BytesIO()
    follow(beside(run), source, out)
    text, messages = out.getvalue(), []
    while text:
        (length,) = LENGTH.unpack_from(text)
        messages.append(text[LENGTH.size : LENGTH.size + length])
        text = text[LENGTH.size + length :]
    check_as_replayed(run, "timestamps", unpacked(messages)["timestamps"])
