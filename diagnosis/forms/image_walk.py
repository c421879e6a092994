"""An image that strays as a random walk does (sensor_walk.py)."""

from functools import partial

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.forms.courses import of_walk
from stillarm.diagnosis.forms.sensor_walk import nats_ahead, walk_in

CHANNEL = "displacement"
image_walk = partial(walk_in, channel=CHANNEL)


def is_foretold(last: Fit, other: Fit) -> bool:
    """Whether another fit gives what strays a reason, such as a lens or the joint."""
    return nats_ahead(last, other, CHANNEL) >= 0.0


FORM: Form = of_walk("tracking_drift", "rate_px_per_s", CHANNEL, "strayed image", image_walk)
