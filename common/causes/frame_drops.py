"""Frames that are lost."""

from stillarm.common.causes.declaration import Cause, Parameter


def law(drawn: float, fraction: float) -> bool:
    """Whether a frame is lost."""
    return drawn < fraction


CAUSE = Cause(
    "frame_drops",
    "timing",
    name="frames that are lost",
    sees="frames are missing singly; a counter of exposures shows the gaps",
    note="A triggered camera is asked again after a second without an answer.",
    equation="each frame is lost with that probability",
    parameters=(Parameter("fraction", "1", 0.0, 0.95, (0.03, 0.3), neutral=0.0),),
    provoke="any recording of a minute.",
    acts="loss",
    law=law,
)
