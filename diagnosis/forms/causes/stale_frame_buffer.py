"""A buffer that hands over old images."""

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import (
    MOST_PENALTY_NATS,
    Cause,
    Context,
    Trial,
    Values,
    free_of,
    has,
    plain,
)


def _trials(context: Context) -> list[Trial]:
    return [
        Trial({"timing.stale_onset_s": onset}, ({"timing.stale_frames": 1.0},))
        for onset in context.onsets(24)
    ]


def _values(fit: Fit) -> Values:
    return plain(fit, onset_s="timing.stale_onset_s", frames="timing.stale_frames")


_WHOLE = 0.02  # frames: to which the fit's own doubt of a whole number is not believed


def unwhole(frames: float, std: float) -> float:
    """Nats by which a number of frames is unlikely: a buffer holds whole ones, at least one. std: its deviation."""
    return min(0.5 * ((frames - max(round(frames), 1)) / max(std, _WHOLE)) ** 2, MOST_PENALTY_NATS)


LEAST_FRAMES = 0.5
"""A buffer holds whole images: what is nearer to none is another kind of lateness."""


CAUSE = Cause(
    id="stale_frame_buffer",
    needs=has("displacement"),
    trials=_trials,
    free=free_of("timing.stale_frames"),
    possible=lambda fit: abs(fit.value("timing.stale_frames")) > LEAST_FRAMES,
    parameters_of=_values,
    settle={"timing.stale_onset_s": 0.5},
    prior_penalty=lambda fit: unwhole(*plain(fit, frames="timing.stale_frames")["frames"]),
)
