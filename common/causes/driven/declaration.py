"""What a declaration says of a cause in a joint that is driven by a torque, a current or a voltage."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class DrivenCause:
    """name: a noun phrase, as the report has it. sees: in one sentence. equation: of theta'', all torques divided by
    the hub's inertia. numbers: of the simulation (stillarm.simulation.arm.torque_joint) that it sets. provoke: what to
    do so that it shows. confused_with: by other cause, the experiment that separates the two."""

    identifier: str
    name: str
    sees: str
    equation: str
    numbers: tuple[str, ...]
    provoke: str
    confused_with: Mapping[str, str] = field(default_factory=dict)
