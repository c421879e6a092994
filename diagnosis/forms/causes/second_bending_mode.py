"""A second bending mode."""

from collections.abc import Sequence
from math import pi

import numpy as np

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Cause, Context, Trial, Values, arm_moves, plain
from stillarm.diagnosis.physics.world import World


def _mode(world: World) -> int:
    return world.modes - 1


def _free(world: World) -> tuple[str, ...]:
    i = _mode(world)
    names = [f"modes.{i}.frequency_hz", f"modes.{i}.damping_ratio"]
    if not world.measured.pair:
        names.append(f"modes.{i}.participation")
    for j in range(len(world.impacts) + 1):
        names += [f"jump.{j}.{i}.q", f"jump.{j}.{i}.v"]
    return tuple(names)


def _trials(context: Context) -> list[Trial]:
    world = context.world
    first = context.value("modes.0.frequency_hz")
    top = min(0.3 / world.measured.cycle_s, 40.0 * first)
    peaks = {f for channel in context.peaks_hz.values() for f in channel}
    grid = np.geomspace(1.3 * first, top, 14) if top > 1.5 * first else np.empty(0)
    trials = []
    i = world.modes
    for f in sorted({*peaks, *(float(x) for x in grid)}):
        if not 0.2 * first < f < 0.45 / world.measured.cycle_s:
            continue
        if not _apart(f, [context.value(f"modes.{j}.frequency_hz") for j in range(world.modes)]):
            continue
        size = 0.01 * context.amplitude_m
        columns: list[dict[str, float]] = [] if world.measured.pair else [{f"modes.{i}.participation": 0.01}]
        for j in range(len(world.impacts) + 1):
            columns.append({f"jump.{j}.{i}.q": size})
            columns.append({f"jump.{j}.{i}.v": size * 2.0 * pi * f})
        shape = {f"modes.{i}.frequency_hz": f, f"modes.{i}.damping_ratio": 0.01}
        trials.append(Trial(shape, tuple(columns), options=(("extra_modes", 1),)))
    return trials


def _apart(hz: float, known_hz: Sequence[float]) -> bool:
    """Whether a frequency may be of a further bending mode: above the first by a factor of two at least, and clear of
    the others. No beam bends in one plane in two ways nearer each other (a clamped one's second is 6.3 times its first,
    and more with a load at its tip; Blevins, 1979, table 8-1); what rings nearer, or below, is another axis, a mount,
    or a frequency that changes with the amplitude."""
    above = hz > _ABOVE_FIRST * known_hz[0]
    return above and all(max(hz / one, one / hz) > _APART for one in known_hz)


def _rings(fit: Fit) -> bool:
    """Whether it is a mode of its own, and rings."""
    hz = [fit.value(f"modes.{j}.frequency_hz") for j in range(fit.world.modes)]
    damping = fit.value(f"modes.{_mode(fit.world)}.damping_ratio")
    return _apart(hz[-1], hz[:-1]) and _LEAST_DAMPING < damping < _MOST_DAMPING


_ABOVE_FIRST, _APART = 2.0, 1.25  # ratio to the first mode, a third of 6.3; to any other


_MOST_DAMPING = 0.3  # what is gone within a swing is no ring


_LEAST_DAMPING = 2e-4  # a ring that does not decay is kept up by something


def _values(fit: Fit) -> Values:
    i = _mode(fit.world)
    names = ("frequency_hz", "damping_ratio", "participation")
    return plain(fit, **{name: f"modes.{i}.{name}" for name in names})


CAUSE = Cause(
    id="second_bending_mode",
    needs=arm_moves,
    trials=_trials,
    free=_free,
    parameters_of=_values,
    possible=_rings,
)
