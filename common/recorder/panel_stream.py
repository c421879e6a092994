"""The browser panel's texts, which have no place in a plot, beside the telemetry. Pure: messages in, bytes out.

docs/telemetry.md describes the maps. Sent by the recorder's process to telemetry.panel_port, never by the loop.
"""

import msgspec

from stillarm.common.recording.topics import EstimateSample, LogLine, SettingsSample

REPEAT_S = 0.25  # a listener that starts later, or that missed a datagram, knows the words after this time
_MOST_LINES = 32  # in one datagram; a burst of log lines must fit a UDP datagram
_LONGEST_TEXT = 1000
_ENCODE = msgspec.msgpack.Encoder().encode


class PanelStream:
    """Collects words of /estimate and the settings in force, on change and every REPEAT_S, and the lines of /log."""

    def __init__(self, origin_monotonic_s: float) -> None:
        """origin_monotonic_s: cycle 0 on the monotonic clock, s, from which a listener computes a sample's age."""
        self._origin_s = origin_monotonic_s
        self._words: dict[str, str | float] = {}
        self._settings: dict[str, str | float] = {}
        self._time_s = 0.0
        self._sent: dict[str, str | float] = {}
        self._next_s = float("-inf")
        self._lines: list[dict[str, object]] = []

    def take(self, message: msgspec.Struct) -> None:
        """Collect one message of any topic; those without words are left out."""
        if isinstance(message, EstimateSample):
            self._time_s = message.time_s
            self._words = {
                **self._settings,
                "state": message.state,
                "reason": message.reason,
                "damping_status": message.damping_status,
                "delay_status": message.delay_status,
                "deflection_status": message.deflection_status,
                "estimate_reason": message.estimate_reason,
                "trust": message.trust,
            }
        elif isinstance(message, SettingsSample):
            self._settings = {
                "method": message.method,
                "added_damping_ratio": message.added_damping_ratio,
            }
        elif isinstance(message, LogLine) and len(self._lines) < _MOST_LINES:
            line = {"level": message.level, "text": message.text[:_LONGEST_TEXT]}
            self._lines.append({"time_s": message.time_s, "log": line})

    def due(self, now_s: float) -> list[bytes]:
        """The datagrams to send at `now_s`, s on the monotonic clock: none where nothing is new or due again."""
        maps, self._lines = self._lines, []
        changed = self._words != self._sent
        if self._words and (changed or now_s >= self._next_s):
            self._sent = self._words
            self._next_s = now_s + REPEAT_S
            maps.append(
                {"time_s": self._time_s, "words": self._words | {"origin_monotonic_s": self._origin_s}}
            )
        return [_ENCODE(maps)] if maps else []
