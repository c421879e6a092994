"""Waits for the controller's answer to an adjustment in its telemetry, for a command that has no page."""

import time
from collections.abc import Callable
from math import nan

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.user_error import UserError
from stillarm.panel.live.known import Known
from stillarm.panel.live.telemetry import rows_of
from stillarm.panel.operate.answered import WITHIN_S, in_force, refusal_since

# what is asked for may be in force already, and be refused: the words repeat every 0.25 s
_REFUSED_WITHIN_S = 0.3
_PAUSE_S = 0.01


def awaited_answer(asked: Adjustment, drain: Callable[[], list[bytes]]) -> str:
    """What is in force, in words, once the controller has taken what was asked.

    drain: the datagrams of the panel's telemetry that have arrived. Raises UserError, to follow the controller's
    name: it refuses, with its reason; it has not taken it in time; or nothing was heard of it.
    """
    known, began_s = Known(), time.monotonic()
    while (waited_s := time.monotonic() - began_s) < WITHIN_S:
        for datagram in drain():
            known.take(rows_of(datagram), time.monotonic())
        if why := refusal_since(known, nan):
            raise UserError(f"refuses: {why}")
        if waited_s > _REFUSED_WITHIN_S and in_force(asked, known):
            return f"in force ({_settings(known)})"
        time.sleep(_PAUSE_S)
    if not known.words.method:
        raise UserError(
            f"was reached, but no telemetry of it came within {WITHIN_S:g} s (telemetry.host, telemetry.panel_port); "
            "its log says what became of it"
        )
    raise UserError(f"has not taken it within {WITHIN_S:g} s; in force: {_settings(known)}")


def _settings(known: Known) -> str:
    return f"method {known.words.method}, added damping ratio {known.words.added_damping_ratio:g}"
