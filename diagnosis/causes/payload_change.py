"""A payload taken up or put down."""

from diagnosis.cause import Cause, Context, Trial, arm_moves, free_of, plain


def _trials(context: Context) -> list[Trial]:
    return [
        Trial({"arm.onset_s": onset}, ({"arm.frequency_ratio": 1.0 + size},))
        for onset in context.onsets(16)
        for size in (0.002, 0.05, -0.05)
    ]


CAUSE = Cause(
    id="payload_change",
    needs=arm_moves,
    trials=_trials,
    free=free_of("arm.onset_s", "arm.frequency_ratio"),
    parameters_of=lambda fit: plain(fit, onset_s="arm.onset_s", frequency_ratio="arm.frequency_ratio"),
    settle={"arm.onset_s": 0.5},
)
