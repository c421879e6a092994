"""Carries out a page's requests, if the state machine permits them. Edge: the sender, and the simulated rig's
strikes."""

import asyncio
import contextlib
from math import isfinite, isnan
from typing import Any

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Configuration, is_simulated_rig
from stillarm.common.user_error import UserError
from stillarm.controller.safety.adjusting import adjustment_refusal
from stillarm.controller.safety.table import Setting
from stillarm.panel.live.known import Known
from stillarm.panel.operate.actions import COMMANDS, MEANINGS, Action
from stillarm.panel.operate.answered import WITHIN_S, in_force, refusal_since
from stillarm.panel.operate.permitted import Situation, refusal, setting_refusal, words_of
from stillarm.panel.operate.sender import Commands
from stillarm.simulation.rig.strike_requests import request_strike

_LOOK_EVERY_S = 0.05


class Desk:
    """The operator's desk of one controller."""

    def __init__(self, configuration: Configuration, *, held: bool = False) -> None:
        """held: whether to hold the damping from the start. Raises UserError for a key that cannot be read."""
        self._configuration = configuration
        self._commands = Commands(configuration.link)
        self._simulated = is_simulated_rig(configuration)
        self._begin_held = held
        self._holding: asyncio.Task[None] | None = None
        self._known: Known | None = None

    def start(self, known: Known) -> None:
        """Begin, within a running event loop. known: where the controller's words are found."""
        self._known = known
        if self._begin_held:
            self._hold()

    async def close(self) -> None:
        """Hold nothing any longer."""
        if self._holding is not None:
            self._holding.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._holding
            self._holding = None

    def situation(self, known: Known, now_s: float, *, signed_in: bool) -> Situation:
        """The situation that decides which actions are possible at `now_s`, s on the monotonic clock."""
        return Situation(
            known.words.state,
            known.words.reason,
            known.silent(now_s),
            signed_in,
            self._holding is not None,
            known.damping_allowed,
            self._simulated,
        )

    def status(self, known: Known, now_s: float) -> dict[str, Any]:
        """What a page shows beside the curves."""
        now = self.situation(known, now_s, signed_in=True)
        origin_s, exact = known.origin()
        return {
            "silent": now.silent,
            "words": known.words,
            "ground": words_of(known.words.reason),
            "damping_allowed": known.damping_allowed,
            "held": now.held,
            "actions": {action: refusal(action, now) for action in Action},
            "settings": self._settings(known, now),
            "origin_s": round(origin_s, 4) if origin_s < 1e300 else None,
            "origin_exact": exact,
        }

    def _settings(self, known: Known, now: Situation) -> dict[str, Any]:
        """The settings in force, null before the controller has told them; and why they may not be adjusted now."""
        ratio = known.words.added_damping_ratio
        return {
            "method": known.words.method or None,
            "added_damping_ratio": ratio if isfinite(ratio) else None,
            "refusals": {setting: setting_refusal(setting, now) for setting in Setting},
        }

    async def adjust(self, asked: Adjustment, known: Known, now_s: float) -> None:
        """Ask for another method or gain, and wait until it is in force.

        Raises UserError with the reason where it is refused, nobody answers, or the controller does not obey.
        """
        now = self.situation(known, now_s, signed_in=True)
        wanted = [Setting.METHOD] * bool(asked.method) + [Setting.GAIN] * (
            not isnan(asked.added_damping_ratio)
        )
        why = next((why for setting in wanted if (why := setting_refusal(setting, now))), "")
        if why := why or adjustment_refusal(asked, self._configuration.controller, None):
            raise UserError(why)
        asked_s = known.time_s
        await self._commands.adjust(asked)
        for _ in range(round(WITHIN_S / _LOOK_EVERY_S)):
            if why := refusal_since(known, asked_s):
                raise UserError(f"refused by the controller: {why}")
            if in_force(asked, known):
                return
            await asyncio.sleep(_LOOK_EVERY_S)
        raise UserError(
            f"the controller has not said within {WITHIN_S:g} s that it is in force; see its log below"
        )

    def asks(self, action: Action) -> bool:
        """Whether the page must ask before it: something moves."""
        return bool(MEANINGS[action].asks)

    async def act(self, action: Action, known: Known, now_s: float) -> None:
        """Do it. Raises UserError with the reason where it is refused, or nobody answers."""
        why = refusal(action, self.situation(known, now_s, signed_in=True))
        if why:
            raise UserError(why)
        if action is Action.STRIKE:
            request_strike(self._configuration)
        elif action is Action.HOLD_DAMPING:
            self._hold()
        elif action is Action.ALLOW_DAMPING:
            await self.close()
        else:
            bits, _ = COMMANDS[action]
            await self._commands.send(bits)

    def _hold(self) -> None:
        known = self._known
        assert known is not None
        self._holding = asyncio.create_task(self._commands.hold_damping(lambda: known.damping_allowed))
