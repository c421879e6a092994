"""A clock that was set."""

import numpy as np

from stillarm.diagnosis.data.frame_times import request_intervals
from stillarm.diagnosis.data.robust import OUTLYING, SIDE, std_about_median, step_at
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import MOST_PENALTY_NATS, Cause, Context, Trial, free_of, has, plain
from stillarm.diagnosis.sensors.clocks import step_of_arrivals

_ASIDE_S = 0.3  # of an onset: a frame that is under way when the clock is set was asked for before


def _trials(context: Context) -> list[Trial]:
    received = context.world.measured.frames.received_s
    jumps = np.argsort(-np.abs(np.diff(received) - np.median(np.diff(received))))[:4]
    onsets = {*context.onsets(16), *(float(context.world.just_before(i + 1)) for i in jumps)}
    trials = [Trial({"timing.step_onset_s": onset}, ({"timing.step_s": 0.002},)) for onset in sorted(onsets)]
    seen = _seen(context)
    if seen is not None:
        trials.append(Trial({"timing.step_onset_s": seen}, ({"timing.step_s": 0.002},), certain=True))
    return [*trials, *_beside_a_wander(context)]


def _beside_a_wander(context: Context) -> list[Trial]:
    """The step that the arrivals show where the wander's law, learnt without it, takes it up."""
    step = step_of_arrivals(context.fit)
    if step is None:
        return []
    onset = float(context.world.just_before(step.index))
    size = context.value("timing.step_s") + step.step_s
    return [Trial({"timing.step_onset_s": onset}, ({"timing.step_s": size},), exact=True)]


def _seen(context: Context) -> float | None:
    """The instant of the largest surprise among the arrivals, if they stay where it put them."""
    arrivals = context.fit.channel("arrival")
    if arrivals is None:
        return None
    prior_penalty, late = np.nan_to_num(arrivals.residual), arrivals.off
    usual = std_about_median(prior_penalty) + 1e-9
    i = int(np.argmax(np.abs(prior_penalty[SIDE:-SIDE]))) + SIDE if len(prior_penalty) > 3 * SIDE else 0
    if i == 0 or abs(prior_penalty[i]) < OUTLYING * usual:
        return None
    step = step_at(late, i, SIDE)
    if step * prior_penalty[i] <= 0.0 or abs(step) < 0.5 * abs(float(prior_penalty[i])):
        return None
    return float(context.world.just_before(i))


def _unseen(fit: Fit) -> float:
    """Where images are dated by their requests, a clock that was set shows in the requests: none, and it was not."""
    world = fit.world
    if not world.measured.frames.asked:
        return 0.0
    near = np.abs(world.measured.frames.received_s[1:] - fit.value("timing.step_onset_s")) < _ASIDE_S
    if not near.any():
        return 0.0
    intervals = request_intervals(world.measured)
    missed = float(np.min(np.abs(intervals.off_s[near] - fit.value("timing.step_s")))) / intervals.usual_s
    return min(0.5 * missed**2, MOST_PENALTY_NATS)


CAUSE = Cause(
    id="clock_step",
    needs=has("displacement", "arrival"),
    trials=_trials,
    free=free_of("timing.step_s"),
    parameters_of=lambda fit: plain(fit, onset_s="timing.step_onset_s", step_s="timing.step_s"),
    settle={"timing.step_onset_s": 0.5},
    prior_penalty=_unseen,
)
