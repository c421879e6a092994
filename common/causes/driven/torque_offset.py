"""A torque that never ends."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "torque_offset",
    name="a torque that never ends",
    sees="the joint drifts one way at no input",
    equation="theta'' = ... + c",
    numbers=("offset",),
    provoke="hold the input at zero for some seconds in several poses.",
    confused_with={"gravity_load": "hold the input at zero in poses far apart"},
)
