"""The baseline: what may be off without being a cause, refitted before any cause is looked for.

Impacts are sought with the frequency that the vibration is seen to have, and higher modes that a fit has lost are begun
again from where the model has them.

A lost mode: while something larger is unexplained, a payload that was put down in mid-run, say, a small mode is bent to
make up for it: its frequency goes elsewhere, and its share to nothing or to another sign. From there no slope leads
back.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import std_about_zero, white_noise, without_spikes
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.frequency_course import frequency_courses, seen_frequency, shares
from stillarm.diagnosis.events.impacts import (
    fit_with_impacts,
    needs_more,
    with_further_impacts,
    with_impacts_in_place,
    with_impacts_sought,
)
from stillarm.diagnosis.events.pulls import without_pulls
from stillarm.diagnosis.fitting.fit import CHANGED_NATS, fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.physics.measured_joint import departure_hz
from stillarm.diagnosis.physics.quantities import HIGHER, RANGE
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.accelerometer_faults import below, ceiling_of

Array = NDArray[np.float64]

HURRIED_STEPS = 5
"""Steps of a fit that only shows the way, or that there is no time for more of."""
_MOVED, _MUCH = 0.003, 3.0  # of the frequency; of the stated noise
_LITTLE = 1.5  # times the noise: a rest below it makes no impacts up
_CLEAR = 10.0  # times an image's noise: a frequency that is a hundredth off leaves more than that within 16 periods
_NO_NOISE = 1e-300  # in a channel's unit: of one without noise any rest is too much
_NEXT_TO_BEST = 0.8  # nats: of two courses seen so nearly alike the fits tell
_ABOUT = (0.5, 1.5)  # times the frequency: where a wrong one leaves its rest
_LIMIT_KNOWN = 0.97  # of the stated range: an accelerometer at that limit is simulated as it is

# a lost mode
_FAR, _LEAST, _LARGEST = 0.03, 0.5, 2.0  # of the model's frequency; of its participation
_SEEN = 0.2  # standard deviation of the participation, over the model's
_OFF = (1.0, 0.98, 1.02)  # of the model's frequency
_BETTER_NATS = 3.0  # 20 to 1 that a mode begun again is the better one


def moved_as_measured(world: World, split: Split) -> World:
    """The world in which the arm is moved by the joint as it was measured, where the drive's model does not foretell
    it."""
    if "joint_position" not in world.channels or world.measured.pair:
        return world
    names = [name for name in world.baseline_names() if name.startswith("start.")]
    begun = fit(make_data(world, split), world.space.vector(), names, iterations=HURRIED_STEPS)
    simulated = world.reported_position(begun.vector)
    return world.changed(joint_hz=departure_hz(world.measured.position, simulated, world.measured.cycle_s))


def fitted_baseline(world: World, split: Split, reached: Callable[[Fit], None] = lambda one: None) -> Fit:
    """The baseline's fit, what held the arm for a while left out; where the accelerometer is at a limit that it should
    not have, started from that of a sensor with such a limit. reached: told of each better fit on the way, for whoever
    runs out of time."""
    acceleration = world.channels.get("acceleration")
    if acceleration is not None:
        ceiling = ceiling_of(acceleration, world.model.accelerometer.noise_std_m_s2)
        if ceiling is not None and ceiling < _LIMIT_KNOWN * world.model.accelerometer.range_m_s2:
            limited = _with_limit(world, split, ceiling)
            there = limited.world
            start = there.space.with_values(limited.vector, {RANGE: there.space[RANGE].start})
            limited = fit(make_data(there, split), start, there.baseline_names())
            reached(limited)
            return without_pulls(limited, split)
    usual = _at_the_seen_frequency(world, split, reached)
    reached(usual)
    let_go = without_pulls(usual, split)
    reached(let_go)
    if _at_its_noise(let_go, split):
        return let_go
    along = _along_a_course(let_go, world, split)
    if along is None:
        return let_go
    reached(along)
    return without_pulls(along, split)


def _at_its_noise(usual: Fit, split: Split) -> bool:
    """Whether one frequency leaves the sensors at the tip little more than their noise for most of the time: no course
    of the frequency needs to be sought then, which takes long. Images that show the vibration clearly suffice: what the
    accelerometer shows beyond that is its own."""
    levels = {
        name: level(sensor.residual, usual, split) / max(white_noise(sensor.residual), _NO_NOISE)
        for name, level in (("acceleration", _left_about_the_mode), ("displacement", _left_in_images))
        if (sensor := usual.channel(name)) is not None
    }
    images = usual.channel("displacement")
    if images is not None and levels["displacement"] < _LITTLE:
        swing = float(np.std(usual.predicted.motion.deflection)) * abs(usual.value("camera.scale_px_per_m"))
        if swing > _CLEAR * white_noise(images.residual):
            return True
    return bool(levels) and max(levels.values()) < _LITTLE


def _left_about_the_mode(residual: Array, usual: Fit, split: Split) -> float:
    """What is left of the accelerometer about the first mode's frequency, m/s^2, median of the blocks. What rings far
    above says nothing of that frequency."""
    levels = []
    hz = usual.value("modes.0.frequency_hz")
    block = split.blocks_of(usual.world.cycle_times)
    for one in range(len(split.held)):
        off = without_spikes(residual[block == one])
        known = np.isfinite(off)
        power = np.abs(np.fft.rfft(np.where(known, off, 0.0))) ** 2 / max(int(known.sum()), 1)
        at = np.fft.rfftfreq(len(off), usual.world.step_s("acceleration"))
        about = (at > _ABOUT[0] * hz) & (at < _ABOUT[1] * hz)
        if about.any() and known.any():
            levels.append(float(np.mean(power[about])))
    return float(np.median(levels)) ** 0.5 if levels else np.inf


def _left_in_images(residual: Array, usual: Fit, split: Split) -> float:
    """What is left of the images, px, median of the blocks."""
    block = split.blocks_of(usual.world.instants(usual.vector))
    levels = [std_about_zero(off) for one in range(len(split.held)) if (off := residual[block == one]).size]
    return float(np.nanmedian(levels)) if levels else np.inf


def _with_limit(world: World, split: Split, ceiling: float) -> Fit:
    """The baseline's fit of a sensor with that limit, m/s^2: with the impacts that what lies below it shows, or with
    those that show once its limit is simulated from there: a vibration is below it long after the impact."""
    below_it = fit_with_impacts(world.with_measured(below(world.measured, ceiling), ()), split)
    there = world.changed(impacts=below_it.world.impacts)
    start = there.space.with_values(carried_over(below_it, there), {RANGE: ceiling})
    kept = fit(make_data(there, split), start, there.baseline_names())
    sought = fit_with_impacts(
        world, split, world.space.with_values(carried_over(kept, world), {RANGE: ceiling})
    )
    return max(kept, sought, key=lambda one: one.train_log_likelihood)


def _at_the_seen_frequency(
    world: World, split: Split, reached: Callable[[Fit], None] = lambda one: None
) -> Fit:
    """The baseline's fit; where its frequency is far from the one that the vibration has from window to window, it is
    stuck between the model's and the true one, and is begun again from there; so it is from its own, if that is not
    what its impacts were sought with and much is left."""
    usual = fit_with_impacts(world, split, reached=reached)
    reached(usual)
    fitted = usual.value("modes.0.frequency_hz")
    hz = seen_frequency(world, usual.predicted.motion, fitted)
    if hz is None and _left_by_a_wrong_start(usual):
        hz = fitted
    if hz is None:
        return usual
    begun = world.space.with_values(world.space.vector(), {"modes.0.frequency_hz": hz})
    other = fit_with_impacts(world, split, begun)
    return other if other.train_log_likelihood > usual.train_log_likelihood + CHANGED_NATS else usual


def _left_by_a_wrong_start(usual: Fit) -> bool:
    """Whether a fit has gone far from the frequency that its impacts were sought with, and leaves far more than the
    accelerometer's noise: at a wrong frequency they are found late, and where there are none."""
    world = usual.world
    sensor = usual.channel("acceleration")
    if not world.impacts or sensor is None:
        return False
    moved = abs(usual.value("modes.0.frequency_hz") / world.space["modes.0.frequency_hz"].start - 1.0)
    return moved > _MOVED and sensor.sigma > _MUCH * world.model.accelerometer.noise_std_m_s2


def _along_a_course(steady: Fit, world: World, split: Split) -> Fit | None:
    """Where the arm's frequency plainly changes, any one frequency hides the impacts in a part of the recording and
    makes up others: the baseline's fit with the impacts that are seen with its course. None where one frequency
    does; but where that one with the first of these impacts is the likelier one, the fit from there. steady: the best
    fit of one frequency so far."""
    courses = frequency_courses(world, world.predict(world.space.vector()).motion)
    most = max((one.nats for one in courses.values()), default=0.0)
    sought, alike = [], []
    for starts in (one.starts(world) for one in courses.values() if one.nats > _NEXT_TO_BEST * most):
        found, plain = _struck_along(starts[0], steady, world, split)
        if plain is None:
            sought.append((found, starts))
        else:
            alike.append(plain)
    if not sought:
        return _likelier(alike, steady, split)
    found, starts = max(sought, key=lambda one: one[0].train_log_likelihood)
    if needs_more(found, steady):
        return None
    if _steady_with_impacts_of(_likeliest(found, split, starts[1:]), steady, split, starts[0]) is None:
        return None  # before its impacts are put in place, which takes long
    struck = with_impacts_in_place(found, split)
    return _steady_with_impacts_of(_likeliest(struck, split, starts[1:]), steady, split, starts[0])


def _struck_along(
    course: dict[str, float], steady: Fit, world: World, split: Split
) -> tuple[Fit, Fit | None]:
    """The fit along a course with the impacts that are seen with it, as long as it needs no more of them to be as
    likely; and where one frequency does as well with the first of them, a fit of that: impacts by the dozen, sought
    with a course that is none, are as good for the one as for the other, and take long."""
    alike: list[Fit | None] = []

    def hopeless(last: Fit) -> bool:
        if not alike:
            plain = _of_one_frequency(last.world, last.vector, steady, split, course, HURRIED_STEPS)
            alike.append(None if _is_better(last, plain) else plain)
        return alike[0] is not None or needs_more(last, steady)

    start = world.space.with_values(world.space.vector(), course)
    # freed: a course that is a little off leaves as much as an impact does
    found = with_impacts_sought(world, split, start, _smooth(course), hopeless)
    return found, alike[0]


def _likelier(alike: Sequence[Fit], steady: Fit, split: Split) -> Fit | None:
    """The likeliest of these fits of one frequency with all impacts that show from there, if it is plainly likelier
    than the best so far with no more of them; None else."""
    best = max(alike, key=lambda one: one.train_log_likelihood, default=None)
    if best is None or len(best.world.impacts) > len(steady.world.impacts) or not _is_better(best, steady):
        return None
    return with_further_impacts(best, split)


def _smooth(course: Iterable[str]) -> tuple[str, ...]:
    """The quantities of a course that a fit follows by slopes, but for the frequency, which it follows anyway."""
    return tuple(name for name in course if name not in ("modes.0.frequency_hz", "arm.onset_s"))


def _likeliest(struck: Fit, split: Split, starts: Sequence[dict[str, float]]) -> Fit:
    """The fit, or one of those with its impacts from these starts."""
    there = struck.world
    data = make_data(there, split)
    others = [fit(data, there.space.with_values(struck.vector, one), struck.free) for one in starts]
    return max((struck, *others), key=lambda one: one.train_log_likelihood)


def _steady_with_impacts_of(seen: Fit, steady: Fit, split: Split, course: Iterable[str]) -> Fit | None:
    """The fit of one frequency with the impacts that are seen with a course of these quantities; None where it does as
    well."""
    there = seen.world.changed(borne_out=frozenset(seen.world.impacts))
    one = _of_one_frequency(there, seen.vector, steady, split, course)
    return one if _is_better(seen, one) else None


def _of_one_frequency(
    there: World, vector: Array, steady: Fit, split: Split, course: Iterable[str], steps: int = 12
) -> Fit:
    """The likelier fit of one frequency in a world of the impacts that are seen with a course of these quantities, of
    two. Begun where the course begins, from its vector, and, as that may be far from the frequency of most of the
    recording, from the steady fit."""
    usual = {name: there.space[name].start for name in course}
    starts = (there.space.with_values(vector, usual), carried_over(steady, there))
    data, names = make_data(there, split), there.baseline_names()
    fits = (fit(data, start, names, iterations=steps) for start in starts)
    return max(fits, key=lambda one: one.train_log_likelihood)


def _is_better(one: Fit, other: Fit) -> bool:
    """Whether a fit of another structure is plainly the likelier one."""
    return one.train_log_likelihood - other.train_log_likelihood > CHANGED_NATS


def lost_modes(one: Fit) -> list[int]:
    """The model's modes beyond the first that a fit has at another frequency, or with another share."""
    return [i for i in range(1, len(one.world.model.arm.modes)) if _is_lost(one, i)]


def _is_lost(one: Fit, mode: int) -> bool:
    """Not where the data hardly show the mode, so that its share is anything."""
    frequency, participation = f"modes.{mode}.frequency_hz", f"modes.{mode}.participation"
    space = one.world.space
    hz, whole = one.value(frequency) / space[frequency].start, space[participation].start or 1.0
    if one.std.get(participation, 0.0) > _SEEN * abs(whole):
        return False
    return abs(hz - 1.0) > _FAR or not _LEAST < one.value(participation) / whole < _LARGEST


def with_lost_modes(one: Fit, split: Split) -> Fit:
    """The fit, or a likelier one with its lost modes begun again."""
    for i in lost_modes(one):
        data = make_data(one.world, split)
        tried = [
            fit(
                data,
                one.world.space.with_values(_begun_again(one, i, off), others),
                one.free,
                colour=one.colour,
            )
            for off in _OFF
            for others in (shares(one.world) if HIGHER in one.free else ({},))
        ]
        best = max(tried, key=lambda other: other.train_log_likelihood)
        one = best if best.train_log_likelihood > one.train_log_likelihood + _BETTER_NATS else one
    return one


def _begun_again(one: Fit, mode: int, off: float) -> Array:
    """The fit's vector with that mode as the model has it, at rest, its frequency off by a factor."""
    space = one.world.space
    jumps = [name for name in space.names("jump.") if name.split(".")[2] == str(mode)]
    values = {name: space[name].start for name in (*space.names(f"modes.{mode}."), *jumps)}
    values[f"modes.{mode}.frequency_hz"] *= off
    return space.with_values(one.vector, values)
