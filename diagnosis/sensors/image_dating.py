"""When a triggered camera's images were taken, and which exposures a free-running one's were, by what they show.

A triggered camera's images are dated by when they were asked for, or by when they arrived. Requests are noted to the
cycle, arrivals scatter by the delay's spread, so that requests date better, unless no request belongs to its image. Two
faults would make them seem worse, and are allowed for before the two are compared: a clock that was set, and a buffer
that from some instant on hands over images some frames old.

Frames that arrivals alone miscounted are recounted by the images. Where the delay wanders by nearly a period within a
second, arrivals look as after a lost frame, and all later images are dated a period late; where several are lost in a
row, arrivals look as if a clock had been set, and all later images are dated early. The images tell, far better than
arrivals do: each is older, or younger, than it was taken for.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.frame_times import MOST_HELD, request_intervals
from stillarm.diagnosis.data.measured import dated_by_requests
from stillarm.diagnosis.data.noise import InstantUncertainty, log_likelihood
from stillarm.diagnosis.data.robust import OUTLYING, SIDE, WHOLE, step_at
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.fitting.fit import CHANGED_NATS, fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

# frames, fewer show no change of their dates; largest irregularities that are tried as a step, a fit each
_FEWEST_REQUESTS, _MOST_STEPS = 20, 3

# a recount
_NEAR_S = 2.0  # between where images grow older and where the arrivals seemed to jump
_MOST = 4  # losses mended: a fit or three each
_LATE = 1.5  # periods: fewer would have been seen, or may be the delay's own wander


def dated(baseline: Fit, split: Split) -> Fit:
    """A triggered camera's images by when they were asked for, where they fit better so than by when they arrived."""
    if not _may_be_by_requests(baseline.world):
        return baseline
    other = _dated_by_requests(baseline, split)
    mended = (other, _perhaps_stepped(other, split), _perhaps_held_back(other, split))
    return other if max(map(image_nats, mended)) > image_nats(baseline) else baseline


def _may_be_by_requests(world: World) -> bool:
    """Whether images are dated by their arrivals, and each request is known."""
    if not world.frame_clock.arrival or "displacement" not in world.channels:
        return False
    return bool(np.isfinite(world.measured.frames.started_s).all())


def _dated_by_requests(baseline: Fit, split: Split) -> Fit:
    """The fit with images dated by their requests, with the impacts that are found so, or those of the baseline, if
    likelier: a search from nothing misses an impact that stands beside what is not judged, and may take two that stand
    near each other otherwise."""
    measured = dated_by_requests(baseline.world.measured)
    sought = fit_with_impacts(baseline.world.with_measured(measured, ()), split)
    if not (baseline.world.impacts or baseline.world.unjudged_s):
        return sought
    struck = baseline.world.with_measured(measured, baseline.world.impacts)
    start = carried_over(baseline, struck)
    kept = fit(make_data(struck, split), start, struck.baseline_names(), colour=baseline.colour)
    return max(kept, sought, key=lambda one: one.train_log_likelihood)


def dated_anew(baseline: Fit, final: Fit, split: Split) -> Fit | None:
    """The baseline of images dated by their requests, where those fit better so beside what was found; None where they
    do not. As long as they are told wrongly by much more than an instant's doubt, no dating is better than another."""
    world = final.world
    if not _may_be_by_requests(world):
        return None
    measured = dated_by_requests(world.measured)
    there = world.with_measured(measured, world.impacts)
    free = dict.fromkeys((*there.baseline_names(), *(one for one in final.free if one in there.space.place)))
    found = fit(make_data(there, split), carried_over(final, there), tuple(free))
    if image_nats(found) <= image_nats(final) + CHANGED_NATS:
        return None
    plain = baseline.world.with_measured(measured, baseline.world.impacts)
    return fit(make_data(plain, split), carried_over(baseline, plain), plain.baseline_names())


def _perhaps_stepped(asked: Fit, split: Split) -> Fit:
    """The fit, or if its images say so, the same with the frames' clock stepped where requests were furthest off
    their interval: dated by a clock that was set, half of the images would be wrong, and arrivals seem better."""
    world = asked.world
    if len(world.measured.frames) <= _FEWEST_REQUESTS:
        return asked
    intervals = request_intervals(world.measured)
    off, usual = intervals.off_s, intervals.usual_s
    best = asked
    for i in np.argsort(-np.abs(off))[:_MOST_STEPS]:
        if abs(off[i]) < OUTLYING * usual:
            break
        step = {"timing.step_onset_s": float(world.just_before(i + 1)), "timing.step_s": off[i]}
        start = world.space.with_values(asked.vector, step)
        one = fit(make_data(world, split), start, (*asked.free, "timing.step_s"), colour=asked.colour)
        best = one if image_nats(one) > image_nats(best) + CHANGED_NATS else best
    return best


def _perhaps_held_back(asked: Fit, split: Split) -> Fit:
    """The fit, or if its images say so, the same with those after an instant older by whole frames: they arrive as
    early after their request as any, so that nothing but what they show tells it."""
    world = asked.world
    found = older_from(asked)
    if found is None:
        return asked
    index, older_s = found
    frames = round(older_s * world.model.camera.frame_rate_hz)
    if not 1 <= frames <= MOST_HELD:
        return asked
    held = {"timing.stale_onset_s": float(world.just_before(index)), "timing.stale_frames": frames}
    start = world.space.with_values(asked.vector, held)
    one = fit(make_data(world, split), start, (*asked.free, "timing.stale_frames"), colour=asked.colour)
    return one if image_nats(one) > image_nats(asked) + CHANGED_NATS else asked


def older_from(asked: Fit) -> tuple[int, float] | None:
    """The frame from which on images are likeliest to be older than those before, and by how much, s: least squares of
    what is left over the images' speed, a lateness of its own before each frame and after it."""
    images = asked.channel("displacement")
    if images is None:
        return None
    residual, rate = images.residual, asked.predicted.rate_px_s
    known = np.flatnonzero(np.isfinite(residual))
    if len(known) < _FEWEST_REQUESTS:
        return None
    colour = images.colour
    weight = colour.noise_px / colour.stds[known] if isinstance(colour, InstantUncertainty) else 1.0
    slope = rate[known] * weight
    along, power = np.cumsum(-slope * residual[known]), np.cumsum(slope * slope)
    inner = slice(_FEWEST_REQUESTS // 2, -_FEWEST_REQUESTS // 2)
    before, its_power = along[:-1][inner], np.maximum(power[:-1][inner], 1e-12)
    after, rest_power = along[-1] - before, np.maximum(power[-1] - its_power, 1e-12)
    gains = before**2 / its_power + after**2 / rest_power
    best = int(np.argmax(gains))
    older_s = float(after[best] / rest_power[best] - before[best] / its_power[best])
    return int(known[inner.start + best + 1]), older_s


def image_nats(fitted: Fit) -> float:
    """Log-likelihood of all images, zero where there are none; where instants are in doubt, innovations are scaled to
    the level at rest."""
    images = fitted.channel("displacement")
    if images is None:
        return 0.0
    residual, sigma, colour = images.residual, images.sigma, images.colour
    known = np.isfinite(residual)
    nats = float(np.sum(log_likelihood(residual[known] / sigma, sigma)))
    if isinstance(colour, InstantUncertainty):
        nats -= float(np.sum(np.log(colour.stds[known] / colour.noise_px)))
    return nats


def recounted(baseline: Fit, split: Split) -> Fit:
    """The baseline without the losses that the images speak against, and with those that they speak for."""
    for _ in range(_MOST):
        others = [
            fit(make_data(world, split), carried_over(baseline, world), world.baseline_names())
            for world in _miscounted(baseline)
        ]
        best = max(others, key=image_nats, default=None)
        if best is None or image_nats(best) < image_nats(baseline) + CHANGED_NATS:
            break
        baseline = best
    return baseline


def _miscounted(baseline: Fit) -> list[World]:
    """The worlds with a loss less, or with losses more, than arrivals told; none where they were not asked."""
    world, frames = baseline.world, baseline.world.measured.frames
    if not world.frame_clock.counted or "displacement" not in world.channels:
        return []
    if not frames.counted and np.any(np.diff(frames.counter) > 1):
        return []  # the counter itself tells what was lost
    steps = [*_with_one_loss_less(baseline), *_with_losses_where_late(world)]
    return [_with_steps(world, one) for one in steps]


def _with_steps(world: World, steps: Counts) -> World:
    counter = np.concatenate(([0], np.cumsum(steps))) + world.frame_clock.counts[0]
    frames = replace(world.measured.frames, counter=counter, counted=True)
    return world.with_measured(replace(world.measured, frames=frames))


def _with_one_loss_less(baseline: Fit) -> list[Counts]:
    """The counts' steps without the loss where images grow older; none where no loss was told by arrivals, or none lies
    there."""
    world, frames = baseline.world, baseline.world.measured.frames
    steps = np.diff(world.frame_clock.counts)
    told = np.flatnonzero(steps > 1)
    found = older_from(baseline) if len(told) else None
    if found is None:
        return []
    index, older_s = found
    older = older_s * world.model.camera.frame_rate_hz
    lost = told[int(np.argmin(np.abs(told + 1 - index)))]
    far_s = abs(float(frames.received_s[lost + 1] - frames.received_s[index]))
    if round(older) < 1 or abs(older - round(older)) > WHOLE or far_s > _NEAR_S:
        return []
    steps[lost] -= min(round(older), int(steps[lost]) - 1)
    return [steps]


def _with_losses_where_late(world: World) -> list[Counts]:
    """The counts' steps with about as many frames lost as arrivals are late from there on, where they are so the most
    after a gap as long; none where they nowhere are."""
    steps = np.diff(world.frame_clock.counts)
    late = (world.measured.frames.received_s - world.frame_clock.grid_s) * world.model.camera.frame_rate_hz
    gaps = np.flatnonzero(np.diff(late) > _LATE).tolist()
    stays = [step_at(late, gap + 1, SIDE) for gap in gaps]
    if max(stays, default=0.0) < _LATE:
        return []
    many, gap = max(zip(stays, gaps, strict=True))
    found = []
    for lost in (int(many), int(many) + 1):
        more = steps.copy()
        more[gap] += lost
        found.append(more)
    return found
