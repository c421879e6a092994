"""The one interface behind which every drive stands: it takes a joint velocity command and reports the joint."""

from typing import NamedTuple, Protocol


class JointState(NamedTuple):
    """What the drive last reported. NaN where it reports nothing; age_s counts since the report arrived."""

    position_rad: float
    velocity_rad_s: float
    age_s: float


class Drive(Protocol):
    """A velocity-controlled joint. Constructing opens nothing; start() does."""

    def start(self) -> None:
        """Open the device. Moves nothing."""

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command. The drive's own dead-man timer stops it when commands cease."""

    def state(self) -> JointState:
        """The newest report of the drive; never blocks."""

    def close(self) -> None:
        """Command zero and release the device; may be called twice."""
