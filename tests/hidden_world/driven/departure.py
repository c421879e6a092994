"""How far an effect takes a recording from what the rig would have recorded without it, over the noise.

Both recordings are without noise, under the same excitation: the same command, or in a closed loop the same angle
asked for; there the command counts as a channel. After a refit, what the rig's own parameters can take up is off: the
least squares on what each of them changes, linearised at the plain rig, all channels together.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tests.hidden_world.driven.recording import Recording, record
from tests.hidden_world.driven.rig import Rig, Values

COMMAND = "command"
_NUDGE = 1e-3
_LEAST_COMMAND_NOISE = 5e-3


class Plain:
    """A rig without its effect, and what its parameters change, to compare with."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.recording = record(rig, noise=False)
        self._noise = self._noises()
        self._columns = np.stack(
            [*(self._of(record(r, noise=False)) for r in _nudged(rig)), *self._biases()],
            axis=1,
        )
        self._columns /= np.maximum(np.linalg.norm(self._columns, axis=0), 1e-30)

    def departures(self, changed: Recording, refit: bool) -> dict[str, float]:
        """By channel: rms of what the effect changes, over the channel's noise."""
        rest = self._of(changed)
        if refit:
            rest = rest - self._columns @ np.linalg.lstsq(self._columns, rest, rcond=1e-9)[0]
        parts = rest.reshape(len(self._noise), -1)
        return {name: float(np.sqrt(np.mean(part**2))) for name, part in zip(self._noise, parts, strict=True)}

    def _noises(self) -> dict[str, float]:
        rig, drives = self.rig, self.rig.excitation
        out = {c.kind: max(c.noise, c.quantum / np.sqrt(12.0)) for c in rig.channels}
        if drives.closed:
            own = float(np.hypot(2e-5 * drives.kp, 2e-3 * drives.kd))
            out[COMMAND] = max(own, _LEAST_COMMAND_NOISE * float(np.std(self.recording.command)))
        return out

    def _of(self, changed: Recording) -> Values:
        """All channels' changes over their noises, one after the other."""
        parts = []
        for name, noise in self._noise.items():
            mine = self.recording.command if name == COMMAND else self.recording.channels[name]
            other = changed.command if name == COMMAND else changed.channels[name]
            parts.append((other - mine) / noise)
        return np.concatenate(parts)

    def _biases(self) -> Iterator[Values]:
        """A constant in each channel, but for the command, which is known."""
        for at, name in enumerate(self._noise):
            if name != COMMAND:
                column = np.zeros((len(self._noise), self.rig.rows))
                column[at] = 1.0
                yield column.reshape(-1)


def _nudged(rig: Rig) -> Iterator[Rig]:
    """The rig with one of its parameters a little larger."""
    drive, arm, more = rig.drive, rig.arm, 1.0 + _NUDGE
    yield replace(rig, drive=replace(drive, gain=more * drive.gain))
    yield replace(rig, drive=replace(drive, viscous=more * drive.viscous))
    yield replace(rig, drive=replace(drive, hub_inertia=more * drive.hub_inertia))
    if drive.lag_s > 0.0:
        yield replace(rig, drive=replace(drive, lag_s=more * drive.lag_s))
    if arm.modes:
        yield replace(rig, arm=replace(arm, mass_kg=more * arm.mass_kg))
    for k in range(arm.modes):
        yield replace(rig, arm=replace(arm, frequencies_hz=_nudged_at(arm.frequencies_hz, k)))
        yield replace(rig, arm=replace(arm, damping_ratios=_nudged_at(arm.damping_ratios, k)))


def _nudged_at(values: tuple[float, ...], at: int) -> tuple[float, ...]:
    return tuple(v * (1.0 + _NUDGE) if k == at else v for k, v in enumerate(values))
