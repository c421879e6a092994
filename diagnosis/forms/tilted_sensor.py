"""Gravity in an accelerometer that turns far with the arm: by the sine and cosine of its angle.

    a = ... + A sin(phi) + B (cos(phi) - 1),    phi = theta + share of the tip's slope

What the sensor feels of gravity is g sin(phi + phi_0), phi_0 being its angle to the horizontal where phi is zero: A
is g cos(phi_0), B is g sin(phi_0). The declared law is the first term of its series: at 0.5 rad it is off by 4 %. A
sensor at the tip turns with the whole slope of the tip, one near the hub with the joint alone.
"""

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Cause, Context, Form, Trial, Values, free_of, has, plain
from stillarm.diagnosis.physics.declared_effects import quantity_of
from stillarm.diagnosis.physics.quantities import GRAVITY_COSINE, GRAVITY_SINE, GRAVITY_SLOPE

_DECLARED = quantity_of("gravity_leakage", "gain_m_s2_per_rad")
_TRIED_M_S2 = 0.5  # of each: the sensor's reading is in proportion to it


def _trials(context: Context) -> list[Trial]:
    columns = tuple({name: context.value(name) + _TRIED_M_S2} for name in (GRAVITY_SINE, GRAVITY_COSINE))
    return [Trial({}, columns)]


def _gain(fit: Fit) -> Values:
    """Gain at an angle of zero, on top of a declared one."""
    more, std = plain(fit, gain=GRAVITY_SINE)["gain"]
    return {"gain_m_s2_per_rad": (fit.value(_DECLARED) + more, std)}


FORM = Form(
    Cause(
        id="gravity_leakage",
        needs=has("acceleration"),
        trials=_trials,
        free=free_of(GRAVITY_SINE, GRAVITY_COSINE, GRAVITY_SLOPE),
        parameters_of=_gain,
    ),
    "by the sine of the angle",
)
