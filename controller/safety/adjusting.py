"""Whether an operator's adjustment is within its grounds: state, configured methods, bounds of the gain. Pure."""

from math import isnan
from typing import NamedTuple

import msgspec

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.controller.safety.table import MAY_ADJUST, Setting, State

_REFUSED = "adjustment refused: "
_REPEATS_WITHIN_S = 0.5  # a sender repeats its datagram for some 0.05 s


def offered_methods(configured: ControllerSettings) -> tuple[str, ...]:
    """The methods among which an operator may choose: the configured one first, each once."""
    return tuple(dict.fromkeys((configured.method, *configured.adjustable.methods)))


def max_added_damping_ratio(configured: ControllerSettings) -> float:
    """The greatest gain that an operator may choose."""
    return max(configured.damping.added_damping_ratio, configured.adjustable.max_added_damping_ratio)


def state_refusal(setting: Setting, state: State) -> str:
    """Why a setting may not be adjusted in a state; empty where it may."""
    if (setting, state) in MAY_ADJUST:
        return ""
    remedy = (
        "hold the damping, or disarm, first" if state is State.DAMPING else "bring back what is missing first"
    )
    return f"the {setting} does not change while the state is {state}; {remedy}"


def adjustment_refusal(asked: Adjustment, configured: ControllerSettings, state: State | None) -> str:
    """Why an adjustment is refused; empty where it is within its grounds.

    configured: as the controller started. state: None where it is not known: the controller will judge that.
    """
    ratio, offered = asked.added_damping_ratio, offered_methods(configured)
    most = max_added_damping_ratio(configured)
    if not asked.method and isnan(ratio):
        return "nothing was asked for; name a method or a gain"
    if not isnan(ratio) and not 0.0 <= ratio <= most:
        return (
            f"added damping ratio {ratio:g}: from 0 to {most:g}; "
            "controller.adjustable.max_added_damping_ratio in the configuration bounds it"
        )
    if asked.method and asked.method not in offered:
        return (
            f"method {asked.method!r}: one of {', '.join(offered)}; "
            "controller.adjustable.methods in the configuration offers them"
        )
    if state is None:
        return ""
    of_gain = "" if isnan(ratio) else state_refusal(Setting.GAIN, state)
    return of_gain or (state_refusal(Setting.METHOD, state) if asked.method else "")


def refusal_told(text: str) -> str:
    """Why an adjustment was refused, from a line of the log; empty for any other line."""
    return text.removeprefix(_REFUSED) if text.startswith(_REFUSED) else ""


class Adjusted(NamedTuple):
    """The answer to an adjustment. settings: in force from now on. refused: why it was; empty if it was not."""

    asked: Adjustment
    settings: ControllerSettings
    refused: str

    @property
    def told(self) -> tuple[str, str]:
        """Level and text for the log."""
        if self.refused:
            return "warning", f"{_REFUSED}{self.refused}"
        ratio = self.settings.damping.added_damping_ratio
        return (
            "info",
            f"adjusted by the operator: method {self.settings.method}, added damping ratio {ratio:g}",
        )


class Adjusting:
    """The settings in force, and the judgement of each request. A sender repeats a request: it is answered once."""

    def __init__(self, configured: ControllerSettings, cycle_s: float) -> None:
        """configured: as the controller starts."""
        self._configured = configured
        self.settings = configured
        self._repeat_cycles = round(_REPEATS_WITHIN_S / cycle_s)
        self._last: tuple[str, str] | None = None
        self._last_cycle = 0

    def judge(self, asked: Adjustment, cycle: int, state: State) -> Adjusted | None:
        """The answer, with the settings that the request would make; None for a repeated request."""
        key = asked.method, repr(asked.added_damping_ratio)  # the repr, since NaN is not equal to itself
        repeated = key == self._last and cycle - self._last_cycle <= self._repeat_cycles
        self._last, self._last_cycle = key, cycle
        if repeated:
            return None
        why = adjustment_refusal(asked, self._configured, state)
        return self.refuse(asked, why) if why else Adjusted(asked, _with(self.settings, asked), "")

    def refuse(self, asked: Adjustment, why: str) -> Adjusted:
        """An answer that leaves everything as it is."""
        return Adjusted(asked, self.settings, why)


def _with(settings: ControllerSettings, asked: Adjustment) -> ControllerSettings:
    replace = msgspec.structs.replace
    if not isnan(asked.added_damping_ratio):
        damping = replace(settings.damping, added_damping_ratio=asked.added_damping_ratio)
        settings = replace(settings, damping=damping)
    return replace(settings, method=asked.method) if asked.method else settings
