"""Play between motor and joint (backlash): the joint's motion, and the velocity that carries the motor across.

The joint stands still while the motor crosses the play, and moves with it otherwise. To reverse, the motor has to cross
the play at once: the inverse of the play (G. Tao and P. V. Kokotovic, Adaptive Control of Systems with Actuator and
Sensor Nonlinearities, Wiley 1996, chapter 4), which a motor of finite speed can only approach.
"""

from math import copysign, cos, hypot, sin

from stillarm.controller.joint.drive_model import DriveModel

_APPROACH_LAGS = 1.5  # time constant of the exponential crossing, in lags of the drive
_CROSSING_LAGS = 3.0  # lead of the crossing, in time constants of the approach
_WORTH = 0.05  # of the play: a smaller motion is not worth the impact at its end


class GearPlay:
    """The joint behind a motor and a play, with the attributes of DriveModel for the joint."""

    def __init__(self, motor: DriveModel, gap_rad: float, encoder_on_motor: bool, cycle_s: float) -> None:
        """The motor begins in the middle of the play."""
        self._motor = motor
        self._half_rad = 0.5 * gap_rad
        self._encoder_on_motor = encoder_on_motor
        self._cycle_s = cycle_s
        self.ahead_rad = 0.0
        """Motor position minus theta, within half the gap to either side."""
        self.position_rad = motor.position_rad
        self.velocity_rad_s = 0.0
        self.acceleration_rad_s2 = 0.0
        self.mean_acceleration_rad_s2 = 0.0

    def advance(self, command_rad_s: float) -> None:
        """Advance by one cycle. When the motor meets a flank, theta' jumps to the motor's velocity."""
        before = self._motor.position_rad
        self._motor.advance(command_rad_s)
        self._follow_motor(before, self._cycle_s)

    def advance_many(self, cycles: int, command_rad_s: float) -> None:
        """As DriveModel.advance_many."""
        before = self._motor.position_rad
        self._motor.advance_many(cycles, command_rad_s)
        self._follow_motor(before, cycles * self._cycle_s)

    def _follow_motor(self, before: float, passed_s: float) -> None:
        motor = self._motor
        ahead = self.ahead_rad + motor.position_rad - before
        self.ahead_rad = min(max(ahead, -self._half_rad), self._half_rad)
        in_contact = abs(ahead) >= self._half_rad and ahead * motor.velocity_rad_s > 0.0
        velocity = motor.velocity_rad_s if in_contact else 0.0
        self.mean_acceleration_rad_s2 = (velocity - self.velocity_rad_s) / passed_s
        self.velocity_rad_s = velocity
        self.acceleration_rad_s2 = motor.acceleration_rad_s2 if in_contact else 0.0
        self.position_rad = motor.position_rad - self.ahead_rad

    def report(self, position_rad: float) -> None:
        """Set the encoder's reading, rad."""
        self._motor.position_rad = position_rad if self._encoder_on_motor else position_rad + self.ahead_rad
        self.position_rad = self._motor.position_rad - self.ahead_rad

    @property
    def motor_velocity_rad_s(self) -> float:
        """The motor's."""
        return self._motor.velocity_rad_s


class PlayCrossing:
    """The motor's velocity across the play, in addition to the joint's velocity."""

    def __init__(self, gap_rad: float, lead_s: float, angular_frequency: float, cycle_s: float) -> None:
        """lead_s: delay of the drive. angular_frequency: of the damped vibration, rad/s."""
        self._half_rad = 0.5 * gap_rad
        self._lead_s = lead_s
        self._approach_s = _APPROACH_LAGS * lead_s + cycle_s
        ahead = angular_frequency * _CROSSING_LAGS * self._approach_s
        self._cos, self._sin = cos(ahead), sin(ahead) / angular_frequency
        self._w = angular_frequency
        self._least_rad_s = 0.5 * _WORTH * gap_rad * angular_frequency
        self._side = 0.0

    def velocity_rad_s(self, wanted_rad_s: float, rate_rad_s2: float, play: GearPlay) -> float:
        """wanted_rad_s, rate_rad_s2: the joint's velocity for damping at the time of the drive's response, and its
        rate.

        A vibration that requires too little motion is ignored: crossing would excite more than it damps.
        """
        size = hypot(wanted_rad_s, rate_rad_s2 / self._w)
        if size < self._least_rad_s:
            return 0.0
        soon = wanted_rad_s * self._cos + rate_rad_s2 * self._sin
        self._side = copysign(1.0, soon)
        there = play.ahead_rad + play.motor_velocity_rad_s * self._lead_s
        there = min(max(there, -self._half_rad), self._half_rad)
        return (self._side * self._half_rad - there) / self._approach_s
