"""A camera whose image moves as it turns."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("camera.rotation_px_per_rad")
    return [Trial({}, ({"camera.rotation_px_per_rad": now + size},)) for size in (1.0,)]


CAUSE = Cause(
    id="camera_tilt_coupling",
    needs=has("displacement"),
    trials=_trials,
    free=free_of("camera.rotation_px_per_rad"),
    parameters_of=lambda fit: plain(fit, rotation_px_per_rad="camera.rotation_px_per_rad"),
)
