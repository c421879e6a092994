"""An inertia or payload other than stated, or that changes."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "inertia_change",
    name="an inertia or payload other than stated, or that changes",
    sees="the joint answers every torque by less or more acceleration",
    equation="J theta'' = ..., J other than stated, or from an onset on",
    numbers=("inertia_excess",),
    provoke="record with the payload on and off.",
)
