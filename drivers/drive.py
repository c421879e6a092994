"""The one interface behind which every drive stands: it takes a joint velocity command and reports the joint."""

from typing import NamedTuple, Protocol


class JointState(NamedTuple):
    """What the drive last reported. NaN where it reports nothing.

    age_s: since the drive last said that it follows commands. A drive that is away, disarmed or in a fault of its own
    grows old, whatever else it reports; infinite before the first time; NaN for one that never says anything.
    """

    position_rad: float
    velocity_rad_s: float
    age_s: float


class Drive(Protocol):
    """A velocity-controlled joint. Constructing opens nothing; start() does."""

    def start(self) -> None:
        """Open the device and make it hold a velocity of zero. Raises UserError with a remedy."""

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command. The drive's own dead-man timer stops it when commands cease.

        Never blocks, and never raises for a fault of the device: that shows as the age of its state.
        """

    def state(self) -> JointState:
        """The newest report of the drive; never blocks."""

    def close(self) -> None:
        """Command zero and release the device; may be called twice."""


class DriveProbe(NamedTuple):
    """What a look at a drive found, which commanded nothing but zero, and armed nothing.

    identity: what it says it is; reports: how many came in span_s, at an age of at most 50 ms each where that is known;
    notes: what is not as it should be, each with its remedy.
    """

    identity: str
    reports: int
    span_s: float
    position_rad: float
    notes: tuple[str, ...] = ()
