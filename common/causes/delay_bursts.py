"""Bursts in which frames come late."""

from stillarm.common.causes.declaration import Cause, size


def law(since: float, rate_hz: float, duration_s: float, delay_s: float) -> float:
    """Delay added `since` s after a burst began, s."""
    return delay_s if since < duration_s else 0.0


CAUSE = Cause(
    "delay_bursts",
    "timing",
    name="bursts in which frames come late",
    sees="now and then frames come late for a while, and then catch up, one close behind the other",
    equation="bursts begin at Poisson instants; while one lasts, frames come delay later, in their order",
    parameters=(
        size("rate_hz", "1/s", 100.0, 0.1, 0.5),
        size("duration_s", "s", 100.0, 0.1, 0.5),
        size("delay_s", "s", 10.0, 0.03, 0.1),
    ),
    provoke="any recording of a minute.",
    acts="burst",
    law=law,
)
