"""What a method made of a killed supervisor, from its successor's first image on. Arrays in, numbers out."""

from dataclasses import replace

import numpy as np

from stillarm.benchmarks.live.kills.kill_plan import Kill
from stillarm.benchmarks.live.scoring import Estimates, longest_beyond_s, score, settled_s, visible_amplitude
from stillarm.benchmarks.live.truth import Swing, TrueRun

SETTLED_WITHIN_S = 1.0
"""What is asked, from the first new image on."""


def gap_around(kill: Kill, received_s: list[float]) -> tuple[float, float] | None:
    """(last image before a kill, first one after it), when they were read, s; None where one of them is missing.

    What is read just after a kill was on its way: the longest silence until the arm is struck again counts.
    """
    near = [at for at in received_s if kill.at_s - 1.0 <= at < kill.until_s]
    if len(near) < 2:
        return None
    silences = np.diff(near)
    place = int(np.argmax(silences))
    return near[place], near[place + 1]


def score_kill(
    said: Estimates, truth: TrueRun, kill: Kill, gap: tuple[float, float]
) -> dict[str, float | None]:
    """Scores from the first new image to the next strike, by the names of the benchmark's file.

    amplitude_m: of the true vibration at the first new image. settled_s: from the first new image until the error's
    running mean over 0.25 s stays below 2 %.
    longest_beyond_2_std_s: from the kill on, silence and all. The others as in a whole run.
    """
    swing = Swing(gap[1], kill.until_s)
    of_kill = replace(truth, swings=(swing,))
    error = said.deflection_m - np.interp(said.time_s, truth.time_s, truth.deflection_m)
    visible, amplitude = visible_amplitude(of_kill, swing, said.time_s)
    relative = np.where(np.isfinite(error), np.abs(error) / amplitude, 1.0)
    scores = score(said, of_kill)
    within = [
        "error_mean",
        "error_max",
        "delay_rms_s",
        "delay_normalised_error_squared_max",
        "deflection_normalised_error_squared_max",
    ]
    first = amplitude[visible]
    return {
        "amplitude_m": float(first[0]) if len(first) else None,
        "settled_s": settled_s(said.time_s[visible], relative[visible], swing.begin_s),
        **{name: scores[name] for name in within},
        "longest_beyond_2_std_s": longest_beyond_s(said, error, of_kill, kill.at_s, kill.until_s),
    }
