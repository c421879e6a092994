"""The flood's sender and the marks of the benchmark, without a rig."""

import socket
from pathlib import Path
from typing import Any

from stillarm.benchmarks.faults.flood import damping_share, refused_counts, verdict
from stillarm.benchmarks.faults.flood_sender import sent_by, start_flood
from stillarm.common.datagrams.datagram import DEMO_KEY, Datagram, decode
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.recording.topics import EstimateSample, LinkSample
from stillarm.common.recording.writer import RecordingWriter
from tests.reference.plain_datagram import VISUAL, plain_datagram

HEADER = RecordingHeader(
    program_version="0",
    configuration="",
    configuration_name="",
    model="",
    method="m",
    kind="live",
    origin_monotonic_s=100.0,
)


def test_the_flood_is_what_was_asked_for_and_nothing_of_it_is_true() -> None:
    """At most rate times duration datagrams; none of those that arrive holds a tag of the key."""
    true = [plain_datagram(DEMO_KEY, VISUAL, 1 << 62, 1, [0.0] * 22, echo=1 << 61)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(0.2)
        flooding = start_flood(true, listener.getsockname()[1], 2000.0, 0.25, 3)
        got: list[bytes] = []
        while flooding.poll() is None or not got:
            try:
                got.append(listener.recv(2000))
            except TimeoutError:
                continue
        sent = sent_by(flooding)
    assert 0 < len(got) <= sent <= 500  # fewer where the sender was held up
    assert not any(isinstance(decode(DEMO_KEY, data), Datagram) for data in got)


def recording_of(path: Path) -> Recording:
    writer = RecordingWriter(path, HEADER)
    for cycle in range(1000):
        status = "active" if cycle < 250 or cycle >= 500 else "vision stale"
        numbers = (0.07, 0.001, "estimated", 0.0, 0.0, 0.0, 0.0)
        writer.write("/estimate", EstimateSample(cycle * 0.001, cycle, *numbers, status))
    counts = [f for f in LinkSample.__struct_fields__ if f not in ("time_s", "cycle")]
    zeros: dict[str, Any] = dict.fromkeys(counts, 0) | {"recorder_alive": True}
    for second in (0, 1):
        writer.write("/link", LinkSample(float(second), 1000 * second, **zeros | {"forged": 70 * second}))
    writer.close()
    return open_recording(path)


def test_the_share_damped_is_of_the_span_asked_for(tmp_path: Path) -> None:
    """On the monotonic clock; counts are those of the end."""
    recording = recording_of(tmp_path / "rec.mcap")
    assert damping_share(recording, 100.0, 101.0) == 0.75
    assert damping_share(recording, 100.25, 100.5) == 0.0
    assert damping_share(recording, 100.5, 100.75) == 1.0
    assert damping_share(recording, 200.0, 201.0) == 0.0
    assert refused_counts(recording)["forged"] == 70


def test_twice_the_quiet_misses_are_allowed_and_no_more() -> None:
    def kept(missed: tuple[int, int, int], shares: tuple[float, float, float]) -> list[str]:
        rows = [{"missed": m, "damping_share": s} for m, s in zip(missed, shares, strict=True)]
        return [row["kept"] for row in verdict(rows)]

    assert kept((1, 4, 1), (1.0, 0.95, 1.0)) == ["yes", "yes"]
    assert kept((1, 5, 1), (1.0, 0.95, 1.0)) == ["no", "yes"]
    assert kept((0, 0, 0), (1.0, 0.5, 1.0)) == ["yes", "no"]
