"""A measured recording of a hidden rig: `make(case)`. Nothing here knows the program that is being judged."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.clocks import Frames, frames, read_at
from tests.hidden_world.effects import Effect
from tests.hidden_world.eye import seen
from tests.hidden_world.feeler import converted, felt, spikes
from tests.hidden_world.manoeuvre import plan
from tests.hidden_world.motion import WIDTH, move
from tests.hidden_world.rig import FINE, TICK_S, Rig
from tests.hidden_world.works import inside, moves

Array = NDArray[np.float64]
CHANNELS = ("acceleration", "command", "reference", "angle", "speed", "image", "stamp", "gauge")
EVERY_DAY = frozenset({"acceleration", "command", "reference", "angle", "speed", "image", "stamp"})


@dataclass(frozen=True)
class Case:
    """Everything that a recording follows from. assumed: what its owner believes of the rig."""

    seed: int
    rig: Rig
    assumed: Rig
    effects: tuple[Effect, ...] = ()
    duration_s: float = 20.0
    impacts: bool = True
    damped: bool = False
    kept: frozenset[str] = EVERY_DAY

    @property
    def scale_m(self) -> float:
        """A typical peak of the bending on this arm, m."""
        return self.assumed.usual_bending


@dataclass
class Clean:
    """What the sensors would say without noise, before frames are lost."""

    rows: Array
    command: Array
    reference: Array
    impact_time: Array
    acceleration: Array
    """Before the converter."""
    angle: Array
    speed: Array
    gauge: Array
    frames: Frames
    image: Array


@dataclass
class Recording:
    """What is measured. fast columns have a row a tick, frame columns a row an image; NaN: not measured."""

    case: Case
    time: Array
    acceleration: Array
    command: Array
    reference: Array
    angle: Array
    speed: Array
    gauge: Array
    number: NDArray[np.int64]
    received: Array
    started: Array
    stamp: Array
    image: Array
    truth: dict[str, Array] = field(default_factory=dict)
    """What really happened, and the channels without noise. Never written into a bundle."""


@dataclass
class Open:
    """Small changes to what a rig does, for the oracle: jumps of the state added at the start and at each impact."""

    start: Array | None = None
    impact_change: Array | None = None
    command: Array | None = None
    """Replaces the feedback: exactly this command is given."""


@dataclass
class Moved:
    """The arm's motion, before any sensor sees it."""

    rows: Array
    command: Array
    reference: Array
    impact_time: Array


def run(case: Case, changed: Open | None = None) -> Clean:
    """Simulate a case without noise in its sensors. Raises ValueError where an effect tears the arm apart."""
    return sensed(case, moved(case, changed or Open()))


def moved(case: Case, changed: Open) -> Moved:
    """The motion alone. The last few are remembered: what only sensors and clocks do leaves it as it is."""
    key = _motion_key(case, changed)
    if key in _REMEMBERED:
        _REMEMBERED[key] = _REMEMBERED.pop(key)
    else:
        made = _moved(case, changed)
        while len(_REMEMBERED) >= _MOST_REMEMBERED:
            del _REMEMBERED[next(iter(_REMEMBERED))]
        _REMEMBERED[key] = made
    return _REMEMBERED[key]


_REMEMBERED: dict[Hashable, Moved] = {}
_MOST_REMEMBERED = 4


def _motion_key(case: Case, changed: Open) -> Hashable:
    rig, parts = case.rig, (changed.start, changed.impact_change, changed.command)
    return (
        *(case.seed, case.duration_s, case.impacts, case.damped),
        *(rig.reach, rig.bends, rig.joint, case.assumed),
        *(repr(effect) for effect in case.effects if moves(effect)),
        *(None if part is None else np.asarray(part).tobytes() for part in parts),
    )


def _moved(case: Case, changed: Open) -> Moved:
    rig, cycles = case.rig, round(case.duration_s / TICK_S)
    what = plan(case.assumed, case.seed, case.duration_s, case.impacts, case.damped)
    within = inside(rig, case.effects, cycles, case.scale_m)
    random = np.random.default_rng((case.seed, 1))
    start = _start(case, random) + (changed.start if changed.start is not None else 0.0)
    start[6] = start[0]
    reference, gain = what.reference, what.gain
    if changed.command is not None:
        reference, gain = changed.command, np.zeros(cycles)
    guess_error = 0.02 * case.scale_m * random.standard_normal(cycles)
    impact = what.impact + (changed.impact_change if changed.impact_change is not None else 0.0)
    rows, command = move(
        within.works,
        start,
        reference,
        within.hold_up,
        gain,
        guess_error,
        what.wash_rate,
        what.impact_time,
        impact,
        within.pitch,
        within.push,
    )
    if not np.all(np.isfinite(rows)):
        raise ValueError(
            f"the motion of case {case.seed} with {case.effects} diverges: make the effect smaller"
        )
    return Moved(rows, command, what.reference, what.impact_time)


def sensed(case: Case, motion: Moved) -> Clean:
    """What the sensors and clocks make of a motion, without noise."""
    rig, rows, cycles = case.rig, motion.rows, len(motion.command)
    timing = frames(rig, case.effects, case.duration_s, case.seed)
    ticks = np.arange(cycles) * FINE
    return Clean(
        rows=rows,
        command=motion.command,
        reference=motion.reference,
        impact_time=motion.impact_time,
        acceleration=felt(rig, case.effects, rows, case.scale_m),
        angle=rows[ticks, 0],
        speed=rows[ticks, 1],
        gauge=rows[: cycles * FINE : FINE, 2] + rows[: cycles * FINE : FINE, 4],
        frames=timing,
        image=seen(rig, case.effects, rows, timing.middle, case.scale_m),
    )


def _start(case: Case, random: np.random.Generator) -> Array:
    """At the joint's resting place, ringing a little."""
    start = np.zeros(WIDTH)
    start[0] = case.rig.joint.start_angle
    size, phase = 0.3 * case.scale_m * random.random(), random.uniform(0.0, 2.0 * pi)
    start[2] = size * np.cos(phase)
    start[3] = size * np.sin(phase) * 2.0 * pi * case.rig.bends[0].hertz
    return start


def make(case: Case) -> Recording:
    """A recording, with noise. The noise follows from the seed alone."""
    clean = run(case)
    rig = case.rig
    ticks = len(clean.command)
    time = np.asarray(np.arange(ticks) * TICK_S, dtype=np.float64)
    random = {name: np.random.default_rng((case.seed, 100 + i)) for i, name in enumerate(CHANNELS)}
    hiss = rig.feeler.hiss * random["acceleration"].standard_normal(ticks)
    signal = converted(rig, case.effects, clean.acceleration + hiss + spikes(case.effects, ticks))
    grain, step = rig.feeler.grain, rig.joint.encoder_step
    angle = clean.angle + rig.joint.encoder_noise * random["angle"].standard_normal(ticks)
    image = clean.image + rig.eye.px_noise * random["image"].standard_normal(len(clean.image))
    here = clean.frames
    received = read_at(here.arrival)
    started = _started(here.asked, received)
    jumped = _clock_steps(case, time, received, started, here.stamp)
    time, received, started, stamp = jumped
    inside_run = (read_at(here.arrival) < case.duration_s) & ~here.lost
    number = here.number if rig.eye.counts_exposures else np.cumsum(inside_run) - 1
    arrived = inside_run
    return Recording(
        case=case,
        time=time,
        acceleration=np.round(signal / grain) * grain,
        command=clean.command,
        reference=clean.reference,
        angle=np.round(angle / step) * step,
        speed=clean.speed + rig.joint.rate_noise * random["speed"].standard_normal(ticks),
        gauge=clean.gauge + rig.gauge_noise * random["gauge"].standard_normal(ticks),
        number=number[arrived],
        received=received[arrived],
        started=started[arrived],
        stamp=stamp[arrived] if rig.eye.stamped else np.full(int(np.sum(arrived)), np.nan),
        image=image[arrived],
        truth={
            "bending_m": clean.gauge,
            "joint_rad": clean.rows[::FINE, 6][:ticks],
            "middle_s": here.middle[arrived],
            "blow_time_s": clean.impact_time,
            "acceleration": converted(rig, case.effects, clean.acceleration),
            "angle": clean.angle,
            "speed": clean.speed,
            "image": clean.image[arrived],
        },
    )


def _started(asked: Array, received: Array) -> Array:
    """n_i of each image: the tick at which it was asked for; in freerun soon after the one before was handled."""
    before = np.concatenate([[received[0] - 0.05], received[:-1]]) if len(received) else received
    ticks = np.where(np.isfinite(asked), np.floor(asked / TICK_S), np.round(before / TICK_S) - 1.0)
    out: Array = np.maximum(ticks, 0.0) * TICK_S
    return out


def _clock_steps(
    case: Case, time: Array, received: Array, started: Array, stamp: Array
) -> tuple[Array, Array, Array, Array]:
    """clock_step: `frames` received and started, `stamp` the camera's alone, `all` every column.

    Rough: nine tenths at the onset, the rest 0.2 s later.
    """
    for e in case.effects:
        if e.name != "clock_step":
            continue
        step = round(e["step_s"] / TICK_S)
        later = round(0.1 * step * e.detail)

        def jump(
            at: Array, onset: float = e["onset_s"], parts: tuple[int, int] = (step - later, later)
        ) -> Array:
            return TICK_S * (parts[0] * (at >= onset) + parts[1] * (at >= onset + 0.2))

        when = received.copy()
        if e.kind == "stamp":
            stamp = stamp + jump(when)
            continue
        received, started = received + jump(received), started + jump(started)
        if e.kind == "all":
            time = time + jump(time)
    return time, received, started, stamp
