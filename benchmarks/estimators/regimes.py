"""What the world of the benchmark is drawn from: one table of laws, for the generator and for the bound."""

from dataclasses import dataclass
from math import pi

from common.user_error import UserError

FRAME_S = 1.0 / 65.0
CYCLE_S = 0.001
DURATION_S = 40.0
SETTLING_S = 2.0  # what happens before is not scored
AFTER_BLOW_S = 0.5  # what happens so soon after a blow is scored apart: nobody can foresee a blow
NOISES = (0.1, 0.3, 1.0)

VARIATION_S = 0.0064
DRIFT_TIME_S = 5.0

# What `stillarm commission` states of the two sensors' scales (docs/commission.md): relative standard deviations.
CAMERA_SCALE_STD = 0.001
ACCELEROMETER_SCALE_STD = 0.002


@dataclass(frozen=True)
class Arm:
    """The true arm: one mode, and how it is kept vibrating.

    amplitude_m is the unit of all noises. Blows come blow_every_s apart and bring the amplitude to blow_to of it;
    with damping_ratio = 0.01 and 2.6 Hz it stays within 0.64 to 1.25. blow_s: how long a blow pushes.
    """

    frequency_hz: float = 2.6
    damping_ratio: float = 0.01
    amplitude_m: float = 0.00625
    vision_noise: float = 0.01
    range_m_s2: float = 19.6
    blow_s: float = 0.006
    blow_every_s: tuple[float, float] = (2.4, 3.6)
    blow_to: tuple[float, float] = (1.15, 1.25)

    @property
    def angular_frequency(self) -> float:
        """Undamped, rad/s."""
        return 2.0 * pi * self.frequency_hz

    @property
    def blow_std_m_s(self) -> float:
        """Spread of the velocity that a blow adds, given to the bound as its prior (checked by a test)."""
        return 0.63 * self.angular_frequency * self.amplitude_m


@dataclass(frozen=True)
class Regime:
    """How frames are exposed and how late they come. All times in seconds; laws are Gaussian unless said otherwise.

    Exposure (mid) of frame k: e_k = t0 + k T (1 + skew) + sum of k steps of trigger_walk_s + u_k; u_k follows the
    law of the delay where the camera is triggered and is zero in freerun. Delay at reading: delay_s + slow part
    (first-order Gauss-Markov, drift_s, DRIFT_TIME_S) + white part (jitter_s), frames kept in order, read in the next
    cycle. started = e_k - half a frame - offset - white part (offset_s uniform over half a frame, once a trial), kept
    within the frame before mid-exposure. stamped: the camera's own clock, unknown offset and rate, noise stamp_s.
    """

    name: str
    drift_s: float = 0.0
    jitter_s: float = 0.0
    triggered: bool = False
    stamped: bool = False
    delay_s: float = 0.074
    delay_prior_s: float = VARIATION_S  # how well the mean delay is known beforehand, for the bound
    skew_ppm: float = 100.0  # largest, uniform; of the frame clock and of the stamps
    trigger_walk_s: float = 0.0
    started_white_s: float = FRAME_S / 4.0
    started_offset_s: float = (
        FRAME_S / 4.0
    )  # largest, uniform: with the white part, the spread of one whole frame
    stamp_s: float = 5e-5


def _regime(camera: str, law: str) -> Regime:
    return Regime(
        f"{camera} {law}",
        drift_s=VARIATION_S if law == "drift" else 0.0,
        jitter_s=VARIATION_S if law == "jitter" else 0.0,
        triggered=camera == "triggered",
        stamped=camera == "stamped",
        trigger_walk_s=0.0006 if camera == "triggered" else 0.0,
    )


REGIMES: dict[str, Regime] = {
    regime.name: regime
    for regime in (
        _regime(camera, law)
        for camera in ("freerun", "triggered", "stamped")
        for law in ("constant", "drift", "jitter")
    )
}


def regimes_named(names: list[str] | None) -> list[Regime]:
    """The regimes of those names, all of them for None. Raises UserError for an unknown one."""
    for name in names or ():
        if name not in REGIMES:
            raise UserError(f"regime {name!r}: unknown; use one of {', '.join(REGIMES)}")
    return [REGIMES[name] for name in names] if names else list(REGIMES.values())
