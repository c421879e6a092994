"""What the panel gets beside the telemetry: words at once when they change, again for who comes later, and the log."""

import msgpack

from stillarm.common.recorder.panel_stream import REPEAT_S, PanelStream
from stillarm.common.recording.topics import EstimateSample, FastSample, LogLine, SettingsSample


def estimate(time_s: float, state: str, reason: str = "") -> EstimateSample:
    return EstimateSample(
        time_s, int(time_s * 1000), 0.07, 0.001, "estimated", 0.01, 0.001, 0.01, 0.0, "active", state, reason
    )


def maps(datagrams: list[bytes]) -> list[dict[str, object]]:
    return [one for datagram in datagrams for one in msgpack.unpackb(datagram)]


def test_words_are_sent_on_change_and_repeated() -> None:
    stream = PanelStream(12.5)
    assert stream.due(0.0) == []
    stream.take(estimate(0.001, "armed"))
    (first,) = maps(stream.due(0.0))
    assert first["time_s"] == 0.001
    words = first["words"]
    assert isinstance(words, dict)
    assert (words["state"], words["reason"], words["origin_monotonic_s"]) == ("armed", "", 12.5)
    stream.take(estimate(0.011, "armed"))
    assert stream.due(0.01) == []
    stream.take(estimate(0.021, "degraded", "vision stale"))
    (changed,) = maps(stream.due(0.02))
    assert changed["words"]["state"] == "degraded"  # type: ignore[index]
    assert stream.due(0.02 + 0.9 * REPEAT_S) == []
    (again,) = maps(stream.due(0.02 + REPEAT_S))
    assert again["words"] == changed["words"]


def test_the_words_hold_the_settings_in_force() -> None:
    stream = PanelStream(0.0)
    stream.take(SettingsSample(0.0, 0, "fused", 0.12))
    stream.take(estimate(0.001, "armed"))
    (first,) = maps(stream.due(0.0))
    assert (first["words"]["method"], first["words"]["added_damping_ratio"]) == ("fused", 0.12)  # type: ignore[index]
    stream.take(SettingsSample(0.002, 2, "timestamps", 0.05, "timestamps", 0.05))
    stream.take(estimate(0.002, "armed"))
    (changed,) = maps(stream.due(0.01))  # a change is sent at once
    assert (changed["words"]["method"], changed["words"]["added_damping_ratio"]) == ("timestamps", 0.05)  # type: ignore[index]


def test_log_lines_are_sent_once_and_a_burst_fits_a_datagram() -> None:
    stream = PanelStream(0.0)
    stream.take(FastSample(0.0, 0))
    for number in range(1000):
        stream.take(LogLine(number * 1e-3, "warning", f"{number} " + "x" * 10_000))
    (datagram,) = stream.due(0.0)
    assert len(datagram) < 65_507
    lines = maps([datagram])
    assert lines[0]["log"]["text"].startswith("0 x")  # type: ignore[index]
    assert stream.due(1.0) == []
