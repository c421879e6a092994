"""An amplifier that ignores small inputs."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive

CAUSE = DrivenCause(
    "amplifier_dead_zone",
    name="an amplifier that ignores small inputs",
    sees="small inputs of either sign do nothing",
    equation="u is obeyed as sign(u) max(0, |u| - zone), or as u where |u| > cut and else not at all",
    parameters=(
        positive("dead_zone", "the input's", "dead_zone"),
        positive("dead_cut", "the input's", "dead_cut"),
    ),
    provoke="drive with a slow sine of small amplitude.",
    confused_with={
        "joint_coulomb_friction": "let the joint coast at no input: friction stops it, a dead zone does not"
    },
)
