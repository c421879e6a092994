"""An inertia or payload other than stated, or that changes."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "inertia_change",
    name="an inertia or payload other than stated, or that changes",
    sees="the joint answers every torque by less or more acceleration",
    equation="J theta'' = ..., J other than stated, or from an onset on",
    parameters=(
        signed("excess_ratio", "1", "inertia_excess"),
        signed("step_ratio", "1", "inertia_step"),
        positive("onset_s", "s", "onset"),
        positive("mode_1_inertia_over_hub", "1", "carries_1"),
        positive("mode_2_inertia_over_hub", "1", "carries_2"),
        positive("mode_3_inertia_over_hub", "1", "carries_3"),
    ),
    provoke="record with the payload on and off.",
)
