"""A velocity loop for a joint that a torque, a current or a voltage drives: pure, one step a cycle.

The joint is to move as the model file says of every drive, so that all that is built on the file holds for it as well:

    w_r' = clip(decay (command - w_r), most),   decay = 2 pi bandwidth_hz,   most = max_acceleration_rad_s2

The torque that this needs of a rigid arm is fed forward, and what the encoder lacks is fed back (a model-following
controller of two degrees of freedom; Astrom and Hagglund, Advanced PID Control, 2006, section 5.3):

    torque = J w_r' + d w_r + coulomb w_r / (|w_r| + w_0) + k_p (e + w_i integral of e),   e = w_r(late) - w
    k_p = J_hub w_c,   w_i = w_c / 4,   w_c = min(decay, 0.5 / (dead time + lag + 3/2 cycles))

w_r is compared as late as the joint can follow it. J_hub, not J: above its modes an arm no longer takes part, and a
gain for the whole inertia would be several times too large there. Below w_c the loop is passive, as motor and encoder
sit at the same place, so no bending mode can be made unstable by it. Half a radian is what the delays take of its phase
margin at w_c, w_i another quarter.
"""

from collections import deque
from math import expm1, isfinite, nan, pi

from stillarm.common.files.driven_joint import commanded_joint
from stillarm.common.files.model import Model
from stillarm.drivers.drives.drive import JointState

OLDEST_STATE_S = 0.02
"""Of a report that the loop still acts on, which a gateway owes at least every 20 ms (docs/gateway.md)."""
_DELAY_RAD = 0.5  # of phase at w_c; 60 degrees of margin are left with the integral's share taken
_INTEGRAL_SHARE = 0.25  # w_i of w_c: 14 degrees
# w_0, over which friction changes its sign. With 5 and 50 times as much, dry friction leaves 1.6 and 2.7 times the
# vibration (0.3 N m on 3 kg m^2); with none, a command that is noise would be answered by the whole friction.
_TURNS_RAD_S = 0.0001
_RUNAWAY = 2.0  # times the model's largest velocity: no command leads there
_AGAINST_S = 0.1  # for which a joint may be faster than it is ever told to be, against the torque


class VelocityLoop:
    """Velocity commands in, the drive's input out."""

    def __init__(self, model: Model, name: str = "model") -> None:
        """Raises UserError for a joint that no rig can have or whose input no limit is stated of, ValueError for one
        that follows velocities."""
        joint = commanded_joint(model, name)
        if joint is None:
            raise ValueError("a joint that follows velocities needs no loop")
        self._limit_n_m = joint.most_n_m(name)
        drive, cycle_s = model.drive, model.timing.cycle_s
        self._joint = joint
        self._cycle_s = cycle_s
        decay = 2.0 * pi * drive.bandwidth_hz
        self._share, self._most = -expm1(-decay * cycle_s), drive.max_acceleration_rad_s2
        self._fastest = drive.max_velocity_rad_s
        self._inertia = joint.inertia_kg_m2
        delay_s = drive.dead_time_s + joint.lag_s
        crossover = min(decay, _DELAY_RAD / (delay_s + 1.5 * cycle_s))
        self._gain = joint.hub_inertia_kg_m2 * crossover
        self._integral_gain = self._gain * _INTEGRAL_SHARE * crossover
        self._late_cycles = 1 + round(delay_s / cycle_s)
        self._under_way: deque[float] = deque(maxlen=self._late_cycles)
        self.tripped = False
        """Whether the joint ran away: then it is braked until `reset`."""
        self._against_s = 0.0
        self._rest()

    def reset(self) -> None:
        """Begin anew at rest."""
        self.tripped = False
        self._rest()

    def input_for(self, command_rad_s: float, state: JointState) -> float:
        """The drive's input over the coming cycle, in its unit; NaN, which asks to brake, without a fresh report of the
        joint.

        It is NaN for good once the joint turned faster than twice the model's largest velocity, or for 0.1 s faster
        than that velocity against the torque: an encoder or a motor with the wrong sign does so.
        """
        velocity = state.velocity_rad_s
        if self.tripped or not state.age_s <= OLDEST_STATE_S or not isfinite(velocity):
            self._rest()
            return nan
        error = self._under_way[0] - velocity
        follows = self._share * (command_rad_s - self._reference) / self._cycle_s
        follows = min(max(follows, -self._most), self._most)
        self._reference += follows * self._cycle_s
        self._under_way.append(self._reference)
        wanted = self._torque(follows) + self._gain * error + self._integral
        torque = min(max(wanted, -self._limit_n_m), self._limit_n_m)
        if torque == wanted or (wanted - torque) * error < 0.0:  # no wind-up at the limit
            self._integral += self._integral_gain * error * self._cycle_s
        self._watch(velocity, torque)
        return nan if self.tripped else torque / self._joint.torque_per_input

    def _torque(self, acceleration: float) -> float:
        """What the reference motion needs of a rigid arm, N m."""
        reference = self._reference
        friction = self._joint.coulomb_n_m * reference / (abs(reference) + _TURNS_RAD_S)
        return self._inertia * acceleration + self._joint.damping_n_m_s * reference + friction

    def _watch(self, velocity: float, torque: float) -> None:
        """Trip on a joint that runs away."""
        against = torque * velocity < 0.0 and abs(velocity) > self._fastest
        self._against_s = self._against_s + self._cycle_s if against else 0.0
        if abs(velocity) > _RUNAWAY * self._fastest or self._against_s > _AGAINST_S:
            self.tripped = True

    def _rest(self) -> None:
        self._reference = self._integral = 0.0
        self._against_s = 0.0
        self._under_way.extend([0.0] * self._late_cycles)
