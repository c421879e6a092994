"""A torque that never ends."""

from stillarm.common.causes.driven.declaration import DrivenCause, signed

CAUSE = DrivenCause(
    "torque_offset",
    name="a torque that never ends",
    sees="the joint drifts one way at no input",
    equation="theta'' = ... + c",
    parameters=(signed("offset_rad_s2", "rad/s^2", "offset", required=True),),
    provoke="hold the input at zero for some seconds in several poses.",
    confused_with={"gravity_load": "hold the input at zero in poses far apart"},
)
