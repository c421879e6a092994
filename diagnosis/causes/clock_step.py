"""A clock that was set."""

import numpy as np

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    received = context.world.measured.frames.received_s
    jumps = np.argsort(-np.abs(np.diff(received) - np.median(np.diff(received))))[:4]
    onsets = {*context.onsets(16), *(float(received[i + 1]) - 1e-6 for i in jumps)}
    return [Trial({"timing.step_onset_s": onset}, ({"timing.step_s": 0.002},)) for onset in sorted(onsets)]


CAUSE = Cause(
    id="clock_step",
    needs=has("displacement", "arrival"),
    trials=_trials,
    free=free_of("timing.step_s"),
    parameters_of=lambda fit: plain(fit, onset_s="timing.step_onset_s", step_s="timing.step_s"),
    settle={"timing.step_onset_s": 0.5},
)
