"""Methods beside the one in force, on the rows of the telemetry. Pure: datagrams in, messages for the page out.

They get what the controller got, and the joint moves as it was commanded: each estimate is what that method would have
said here, while the method in force damped.
"""

from collections.abc import Iterable
from typing import Any

import msgspec

from stillarm.common.files.configuration import Controller
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, length_of
from stillarm.common.recording.topics import FastSample, FrameSample
from stillarm.controller.estimation.estimate import Estimate
from stillarm.controller.estimation.methods import make_method
from stillarm.controller.loop.recorded import recorded_cycles
from stillarm.controller.replay.followed_method import FollowedMethod
from stillarm.panel.live.packing import packed

FIRST_KIND = 128  # of the first method's messages; the telemetry's kinds count from 0, and an image is 255
BESIDE_COLUMNS = ("deflection_m", "deflection_std_m", "delay_s", "delay_std_s")
_ANOTHER_RUN_S = 0.5  # a time that goes back by more is another run of the controller, as in page/samples.js


class _Row(msgspec.Struct, gc=False):
    time_s: float = 0.0
    fast: dict[str, Any] | None = None
    frames: dict[str, Any] | None = None


_DECODER = msgspec.msgpack.Decoder(list[_Row])


class Beside:
    """Runs the wanted methods. They begin when they are first wanted, and forget when they no longer are."""

    def __init__(self, model: Model, settings: Controller, name: str, methods: tuple[str, ...]) -> None:
        """settings: the section [controller]; name: of the model's file; methods: all that may be wanted.

        Raises UserError for a model without a length.
        """
        self._model, self._settings, self._name = declared(model), settings, name
        self._length_m = length_of(self._model, name)
        self._kinds = {method: FIRST_KIND + number for number, method in enumerate(methods)}
        self._running: dict[str, FollowedMethod] = {}
        self._fast: list[FastSample] = []
        self._frames: list[FrameSample] = []
        self._newest_s = float("-inf")

    def want(self, methods: Iterable[str]) -> None:
        """Run these from now on. Raises UserError for a method that cannot be made."""
        kept = self._running
        self._running = {one: kept.get(one) or self._begun(one) for one in methods if one in self._kinds}

    def _begun(self, method: str) -> FollowedMethod:
        return FollowedMethod(
            lambda: make_method(method, self._model, self._settings, self._name), self._model, self._length_m
        )

    def take(self, datagram: bytes) -> list[bytes]:
        """A datagram of telemetry: a message for each method, with the cycles that are complete."""
        self._keep(datagram)
        # a cycle's frames follow its row, perhaps in the next datagram: the newest row waits
        fast, self._fast = self._fast[:-1], self._fast[-1:]
        if not fast:
            return []
        frames = [one for one in self._frames if one.cycle <= fast[-1].cycle]
        self._frames = self._frames[len(frames) :]
        cycles = [one for one in recorded_cycles(fast, frames) if one.row is not None]
        times_s = [one.row.time_s for one in cycles if one.row is not None]
        messages = []
        for method, followed in self._running.items():
            columns = _columns([followed.step(cycle) for cycle in cycles])
            messages.append(packed(self._kinds[method], times_s, columns))
        return messages

    def _keep(self, datagram: bytes) -> None:
        try:
            rows = _DECODER.decode(datagram)
        except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError):
            return
        for row in rows:
            try:
                if row.fast is not None:
                    self._see(row.time_s)
                    self._fast.append(FastSample(time_s=row.time_s, **row.fast))
                elif row.frames is not None:
                    self._frames.append(FrameSample(time_s=row.time_s, **row.frames))
            except TypeError:  # of another version's controller
                continue

    def _see(self, time_s: float) -> None:
        if time_s < self._newest_s - _ANOTHER_RUN_S:
            self._fast, self._frames = [], []
            self._running = {method: self._begun(method) for method in self._running}
        self._newest_s = time_s


def _columns(estimates: list[Estimate]) -> list[list[float]]:
    return [
        [one.deflection_m for one in estimates],
        [one.deflection_std_m for one in estimates],
        [one.delay.delay_s for one in estimates],
        [one.delay.std_s for one in estimates],
    ]
