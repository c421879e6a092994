"""An accelerometer whose bias strays as a random walk does (sensor_walk.py)."""

from functools import partial

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.forms.courses import of_walk
from stillarm.diagnosis.forms.sensor_walk import nats_ahead, walk_in

CHANNEL = "acceleration"
bias_walk = partial(walk_in, channel=CHANNEL)


def is_foretold(last: Fit, other: Fit) -> bool:
    """Whether another fit gives what strays a reason, such as gravity along the sensor's axis."""
    return nats_ahead(last, other, CHANNEL) >= 0.0


FORM: Form = of_walk("accelerometer_bias_drift", "rate_m_s3", CHANNEL, "strayed bias", bias_walk)
