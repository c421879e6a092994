"""Telemetry as plain msgpack sees it: what PlotJuggler asks of a datagram, and the batching."""

import math
import re
import socket
from pathlib import Path

import msgpack
import pytest

from stillarm.common.files.configuration import Telemetry
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recorder.telemetry import TELEMETRY_TOPICS, TelemetryBatches
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPIC_INDEX, EstimateSample, FastSample, LogLine


def fast(cycle: int) -> FastSample:
    return FastSample(cycle * 0.001, cycle, acceleration_m_s2=0.5 * cycle, damping_allowed=True)


def estimate(cycle: int) -> EstimateSample:
    return EstimateSample(cycle * 0.001, cycle, 0.07, 0.001, "estimated", 0.01, math.nan, 0.01, 0.1, "active")


def leaves(value: object) -> list[object]:
    return [x for v in value.values() for x in leaves(v)] if isinstance(value, dict) else [value]


def check_form(maps: list[object]) -> None:
    """An array of maps, each with seconds on top, and nothing in them but numbers, bools and maps of those."""
    assert isinstance(maps, list) and maps
    for one in maps:
        assert isinstance(one, dict) and type(one["time_s"]) is float
        assert all(type(leaf) in {float, int, bool} for leaf in leaves(one))


def test_a_second_of_the_loop_goes_out_in_batches_of_the_period() -> None:
    batches, sent, now = TelemetryBatches(Telemetry(period_s=0.04)), [], 0.0
    for cycle in range(1000):
        batches.take("/fast", fast(cycle))
        batches.take("/estimate", estimate(cycle))
        now += 0.001
        sent += [(now, datagram) for datagram in batches.due(now)]
    sent += [(now, datagram) for datagram in batches.due(now + 1.0)]
    assert 25 <= len(sent) <= 27
    times = []
    for _, datagram in sent:
        assert len(datagram) <= 65507
        maps = msgpack.unpackb(datagram)
        check_form(maps)
        times += [(one["time_s"], *sorted(set(one) - {"time_s"})) for one in maps]
    assert times == [(c * 0.001, name) for c in range(1000) for name in ("fast", "estimate")]
    last = msgpack.unpackb(sent[-1][1])[-2:]
    assert last[0]["fast"]["acceleration_m_s2"] == 0.5 * 999 and last[0]["fast"]["damping_allowed"] is True
    assert last[1]["estimate"]["damping_active"] is True and "delay_status" not in last[1]["estimate"]


def test_each_nth_cycle_and_never_a_datagram_too_large() -> None:
    batches = TelemetryBatches(Telemetry(every_cycles=10))
    for cycle in range(100):
        batches.take("/fast", fast(cycle))
    (datagram,) = batches.due(0.0)
    assert [one["fast"]["cycle"] for one in msgpack.unpackb(datagram)] == list(range(0, 100, 10))
    batches = TelemetryBatches(Telemetry())
    for cycle in range(3000):
        batches.take("/fast", fast(cycle))
    datagrams = batches.due(0.0)
    assert len(datagrams) > 3 and max(map(len, datagrams)) < 65507
    assert sum(len(msgpack.unpackb(d)) for d in datagrams) == 3000


def test_the_document_names_the_topics_that_are_sent() -> None:
    text = (Path(__file__).parents[3] / "docs" / "telemetry.md").read_text(encoding="utf-8")
    (row,) = (line for line in text.splitlines() if line.startswith("| the other key |"))
    assert re.findall(r"`(\w+)`", row) == sorted(topic.short_name for topic in TELEMETRY_TOPICS)


@pytest.mark.slow
@pytest.mark.parametrize("record", [True, False])
def test_the_recorders_process_sends_it_with_and_without_a_recording(
    record: bool, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """And prints what is logged, as one JSON object a line."""
    header = RecordingHeader(
        program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
    )
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(20.0)
        path = tmp_path / "a.mcap" if record else None
        settings = Telemetry(port=listener.getsockname()[1])
        client = RecorderClient.start(path, header, telemetry=settings, process_name="tester")
        for cycle in range(100):
            client.put(TOPIC_INDEX["/fast"], fast(cycle))
        client.put(TOPIC_INDEX["/log"], LogLine(0.1, "warning", "drive silent; check its cable"))
        cycles: list[int] = []
        while len(cycles) < 100:
            maps = msgpack.unpackb(listener.recv(65536))
            check_form(maps)
            cycles += [one["fast"]["cycle"] for one in maps if "fast" in one]
        assert cycles == list(range(100))
        assert client.close()
    assert record == (tmp_path / "a.mcap").exists()
    (line,) = [x for x in capfd.readouterr().err.splitlines() if "drive silent" in x]
    assert line.startswith('{"time":"') and '"level":"warning","process":"tester"' in line
