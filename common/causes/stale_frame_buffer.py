"""A buffer that hands over old frames."""

from stillarm.common.causes.declaration import ONSET, Cause, Parameter


def law(t: float, onset_s: float, frames: float) -> int:
    """How many exposures old the image is."""
    return int(frames) if t >= onset_s else 0


CAUSE = Cause(
    "stale_frame_buffer",
    "timing",
    name="a buffer that hands over old frames",
    sees="from an instant on every image is one or more frames older than its number and its stamp say",
    note="Unstamped, it looks like a step of the delay.",
    equation="from onset on the image handed over as k is exposure k - frames",
    parameters=(
        ONSET,
        Parameter("frames", "frames", 0.0, 32.0, (1.0, 3.0), neutral=0.0, kind="whole"),
    ),
    provoke="keep the arm ringing on both sides of the onset, with the camera's stamps recorded.",
    acts="age",
    law=law,
    confused_with={
        "clock_step": (
            "record with the camera's stamps (captured_s) or its counter of exposures: a stale buffer "
            "shifts the content, a clock step the arrival"
        ),
    },
)
