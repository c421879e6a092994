"""The controller's answer to an adjustment, as its telemetry tells it: in force, refused, or nothing yet. Pure."""

from math import isnan

from stillarm.common.datagrams.messages import Adjustment
from stillarm.controller.safety.adjusting import refusal_told
from stillarm.panel.live.known import Known

WITHIN_S = 1.5
"""Within which the controller's telemetry tells what became of an adjustment: its words repeat every 0.25 s."""


def in_force(asked: Adjustment, known: Known) -> bool:
    """Whether the settings that the controller last told are those asked for."""
    words, ratio = known.words, asked.added_damping_ratio
    return asked.method in {"", words.method} and (isnan(ratio) or words.added_damping_ratio == ratio)


def refusal_since(known: Known, time_s: float) -> str:
    """Why the controller has refused an adjustment after a time, s on its clock; empty where it has not.

    NaN: among all the lines that were heard.
    """
    since = [line for line in known.lines if isnan(time_s) or _time_s(line) > time_s]
    return next((why for line in reversed(since) if (why := refusal_told(str(line["text"])))), "")


def _time_s(line: dict[str, object]) -> float:
    time_s = line["time_s"]
    assert isinstance(time_s, float | int)
    return time_s
