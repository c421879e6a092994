"""Declaration of a cause in a joint that a torque, a current or a voltage drives."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import exp, log

from stillarm.common.causes.declaration import Parameter

CHANNELS = (
    "joint_position_rad",
    "motor_position_rad",
    "joint_velocity_rad_s",
    "deflection_m",
    "strain",
    "acceleration_m_s2",
)
"""Which a sensor's cause may be in."""
_LARGEST = 1e9  # beyond any rig


@dataclass(frozen=True, slots=True)
class DrivenParameter(Parameter):
    """A parameter as a model file has it. number: the simulation's, to which {channel} adds the effect's channel; ""
    for the channel itself. logarithm: whether that number is the value's natural logarithm."""

    number: str = ""
    logarithm: bool = False


def signed(name: str, unit: str, number: str, required: bool = False) -> DrivenParameter:
    """A number of either sign, 0 where it is left out."""
    return DrivenParameter(name, unit, -_LARGEST, _LARGEST, default=None if required else 0.0, number=number)


def positive(
    name: str, unit: str, number: str, required: bool = False, logarithm: bool = False
) -> DrivenParameter:
    """A number that is never negative; left out it stays as the rig shows it."""
    lowest = 1e-9 if logarithm else 0.0
    default = None if required else float("nan")
    return DrivenParameter(name, unit, lowest, _LARGEST, default=default, number=number, logarithm=logarithm)


def of_channel(required: bool = True) -> DrivenParameter:
    """Which channel a sensor's cause is in."""
    return DrivenParameter("channel", "", kind="text", choices=CHANNELS, default=None if required else "")


@dataclass(frozen=True, slots=True)
class DrivenCause:
    """name: a noun phrase, as the report has it. sees: in one sentence. equation: of theta'', all torques divided by
    the hub's inertia. parameters: as an entry of [[effects]] has them. provoke: what to do so that it shows.
    confused_with: by other cause, the experiment that separates the two. repeatable: whether a model may hold
    several effects of it."""

    identifier: str
    name: str
    sees: str
    equation: str
    parameters: tuple[DrivenParameter, ...]
    provoke: str
    confused_with: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = False

    def numbers_of(self, effect: Mapping[str, float | int | bool | str]) -> dict[str, float]:
        """The simulation's numbers that an effect states, by name."""
        channel = str(effect.get("channel", ""))
        return {
            one.number.format(channel=channel).strip(): log(value) if one.logarithm else value
            for one in self.parameters
            if one.number and one.name in effect
            for value in (float(effect[one.name]),)
        }

    def effect_of(
        self, numbers: Mapping[str, float], channel: str = ""
    ) -> dict[str, float | int | bool | str]:
        """The entry of [[effects]] that states the simulation's numbers, as far as it has them."""
        effect: dict[str, float | int | bool | str] = {"cause": self.identifier}
        if channel:
            effect["channel"] = channel
        for one in self.parameters:
            number = one.number.format(channel=channel).strip()
            if one.number and number in numbers:
                value = exp(numbers[number]) if one.logarithm else numbers[number]
                effect[one.name] = float(min(max(value, one.lowest), one.highest))
        return effect
