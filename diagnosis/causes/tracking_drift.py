"""Tracked features that drift."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("camera.rate_px_per_s")
    return [Trial({}, ({"camera.rate_px_per_s": now + size},)) for size in (0.01,)]


CAUSE = Cause(
    id="tracking_drift",
    needs=has("displacement"),
    trials=_trials,
    free=free_of("camera.rate_px_per_s"),
    parameters_of=lambda fit: plain(fit, rate_px_per_s="camera.rate_px_per_s"),
)
