"""Recordings of one rig, one after the other in one table of samples."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.split import Split, stated
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import MOST_SAMPLES, Driven, Output, thinned

_SAME_RATE = 1e-3  # of a step: clocks that are set alike


def joined(recordings: Sequence[Driven]) -> Driven:
    """All of them as one, at the slowest's rate. Raises UserError, one line, where they cannot be one rig's."""
    first = recordings[0]
    for one in recordings:
        if one.drive != first.drive or one.drive_stated != first.drive_stated:
            raise UserError(
                f"{one.name}: its input is {_input(one)}, that of {first.name} {_input(first)}; one rig's recordings "
                "have the same input in the same unit: diagnose them apart (--apart)"
            )
    step = max(one.step_s for one in recordings)
    even = [_at_rate(one, step) for one in recordings]
    # all are thinned alike where they are too many together
    even = [thinned(one, 1 + sum(each.samples for each in even) // MOST_SAMPLES) for one in even]
    common = [
        name
        for name in (output.name for output in first.outputs)
        if all(name in (output.name for output in one.outputs) for one in even)
    ]
    if not common:
        raise UserError(
            f"{recordings[-1].name}: no channel is in every recording; diagnose them apart (--apart)"
        )
    edges = np.cumsum([one.samples for one in even])
    left_out = dict(first.left_out)
    for one in even:
        left_out |= {o.name: "not in every recording" for o in one.outputs if o.name not in common}
    return replace(
        even[0],
        name=", ".join(one.name for one in recordings),
        u=np.concatenate([one.u for one in even]),
        outputs=tuple(_output(name, even) for name in common),
        left_out=left_out,
        joins=tuple(int(one) for one in edges[:-1]),
    )


def joined_split(
    driven: Driven, origins_s: Sequence[float], hold_out: Sequence[tuple[float, float]]
) -> Split:
    """Which blocks are held out: of each recording as of one alone; spans that the user states hold in each."""
    edges, held, at = [np.zeros(1)], [], 0.0
    for k, origin_s in enumerate(origins_s):
        duration_s = driven.part(k).duration_s
        one = stated(hold_out, origin_s, duration_s) if hold_out else irregular(duration_s)
        edges.append(at + one.edges_s[1:])
        held.append(one.held)
        at += duration_s
    return Split(np.concatenate(edges), np.concatenate(held), lends=not hold_out)


def _input(driven: Driven) -> str:
    return driven.drive if driven.drive_stated else f"{driven.drive} of unknown unit"


def _at_rate(driven: Driven, step_s: float) -> Driven:
    """A recording with as many samples a second as the slowest. Raises UserError where no whole number of its samples
    is one of those."""
    every = max(1, round(step_s / driven.step_s))
    if abs(every * driven.step_s / step_s - 1.0) > _SAME_RATE:
        raise UserError(
            f"{driven.name}: {1.0 / driven.step_s:g} Hz is no multiple of {1.0 / step_s:g} Hz, at which another "
            "recording was sampled; diagnose them apart (--apart)"
        )
    return replace(thinned(driven, every), step_s=step_s)


def _output(name: str, recordings: Sequence[Driven]) -> Output:
    each = [next(one for one in driven.outputs if one.name == name) for driven in recordings]
    return replace(
        each[0],
        values=np.concatenate([one.values for one in each]),
        stated=all(one.stated for one in each),
        step=max(one.step for one in each),
    )
