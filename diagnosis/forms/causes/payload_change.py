"""A payload taken up or put down."""

from dataclasses import replace

from stillarm.diagnosis.events.frequency_course import shares
from stillarm.diagnosis.forms.cause import Cause, Context, Trial, arm_moves, of_the_modes, plain, share_of

ID, RATIO = "payload_change", "arm.frequency_ratio"


def _trials(context: Context) -> list[Trial]:
    trials = [
        Trial({"arm.onset_s": onset, **others}, ({RATIO: 1.0 + size},))
        for others in shares(context.world)
        for onset in context.onsets(16)
        for size in (0.002, 0.05, -0.05)
    ]
    return [*trials, *(one for seen in context.along_a_course(ID, RATIO) for one in _about(seen, context))]


def _about(seen: Trial, context: Context) -> list[Trial]:
    """The onset is known to a few periods, a refit finds it within one."""
    onset, period = seen.shape["arm.onset_s"], 1.0 / context.value("modes.0.frequency_hz")
    return [
        replace(seen, shape={**seen.shape, "arm.onset_s": onset + many * period})
        for many in (-4.0, -2.0, 0.0, 2.0, 4.0)
    ]


CAUSE = Cause(
    id=ID,
    needs=arm_moves,
    trials=_trials,
    free=of_the_modes("arm.onset_s", RATIO),
    parameters_of=lambda fit: plain(fit, onset_s="arm.onset_s", frequency_ratio=RATIO) | share_of(fit),
    settle={"arm.onset_s": 0.5},
)
