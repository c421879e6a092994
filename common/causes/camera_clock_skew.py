"""A camera clock that runs at another rate."""

from stillarm.common.causes.declaration import Cause, size


def law(skew_ppm: float) -> float:
    """Frame period over the declared one."""
    return 1.0 + 1e-6 * skew_ppm


CAUSE = Cause(
    "camera_clock_skew",
    "timing",
    name="a camera clock that runs at another rate",
    sees=(
        "frames come a little slower (positive), or faster, than the declared rate, evenly; dated by "
        "counting they slide away"
    ),
    equation="frame period T (1 + 1e-6 skew)",
    parameters=(size("skew_ppm", "ppm", 100000, 100.0, 800.0, signed=True),),
    provoke="a long recording of a camera in freerun.",
    acts="period",
    law=law,
    confused_with={
        "delay_drift": (
            "record with the accelerometer or the camera's stamps, or move the joint throughout: the "
            "images' content then tells when they were taken"
        ),
    },
)
