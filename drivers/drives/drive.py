"""The interface of every drive: it accepts a joint velocity command and reports the joint."""

from typing import NamedTuple, Protocol


class JointState(NamedTuple):
    """The last report of the drive. NaN for quantities that it does not report.

    age_s: time since the drive last confirmed that it follows commands. It grows while the drive is absent, disarmed or
    in a fault, even if other reports arrive; infinite before the first report; NaN for a drive without reports.
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

        Never blocks, and never raises for a fault of the device, which shows up as the age of its state.
        """

    def state(self) -> JointState:
        """The newest report of the drive; never blocks."""

    def close(self) -> None:
        """Command zero and release the device; may be called twice."""


class DriveProbe(NamedTuple):
    """Result of a query of a drive, which commanded only zero and armed nothing.

    identity: as the drive states it; reports: number received in span_s, each at most 50 ms old if its age is known;
    notes: problems, each with its remedy.
    """

    identity: str
    reports: int
    span_s: float
    position_rad: float
    notes: tuple[str, ...] = ()
