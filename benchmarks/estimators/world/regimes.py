"""The distributions of the benchmark's world: one table for the generator and the bound."""

from dataclasses import dataclass
from math import pi

from stillarm.common.user_error import UserError

FRAME_S = 1.0 / 65.0
CYCLE_S = 0.001
DURATION_S = 40.0
SETTLING_S = 2.0  # the time before is not scored
AFTER_IMPACT_S = 0.5  # after an impact, scored separately: no estimator can predict an impact
NOISES = (0.1, 0.3, 1.0)  # of the accelerometer, as fractions of the amplitude's acceleration

VARIATION_S = 0.0064
DRIFT_TIME_S = 5.0

# Relative standard deviations that `stillarm commission` states for the two sensors' scales (docs/commission.md).
CAMERA_SCALE_STD = 0.001
ACCELEROMETER_SCALE_STD = 0.002


@dataclass(frozen=True)
class Arm:
    """The true arm: one mode and its excitation.

    amplitude_m is the unit of all noises. Impacts come impact_every_s apart and bring the amplitude to impact_to of it;
    with damping_ratio = 0.01 and 2.6 Hz it stays within 0.64 to 1.25. impact_s: duration of an impact.
    """

    frequency_hz: float = 2.6
    damping_ratio: float = 0.01
    amplitude_m: float = 0.00625
    vision_noise: float = 0.01
    range_m_s2: float = 19.6
    impact_s: float = 0.006
    impact_every_s: tuple[float, float] = (2.4, 3.6)
    impact_to: tuple[float, float] = (1.15, 1.25)

    @property
    def angular_frequency(self) -> float:
        """Undamped, rad/s."""
        return 2.0 * pi * self.frequency_hz

    @property
    def impact_std_m_s(self) -> float:
        """Spread of the velocity that an impact adds, the prior of the bound (a test checks it)."""
        return 0.63 * self.angular_frequency * self.amplitude_m


@dataclass(frozen=True)
class Busy:
    """How a busy computer delivers images: busy_computer.py has the equations, docs/benchmark-estimators.md the origin.

    The figures come from 15 runs of `stillarm demo` in real time on a machine with two cores, half of them next to a
    second demo. Times in seconds.
    """

    earliest_s: float = 0.050  # earliest delivery after mid-exposure: exposure, read-out, transfer
    mean_std_s: float = 0.005  # of a trial's mean delay around delay_s
    scheduling_s: float = 0.004  # mean scheduling delay of each image, gamma of shape 2
    service_s: float = 0.004  # tracking and network: shortest time from one image to the next
    service_tail_s: float = 0.001  # mean of the additional time, exponential
    # intervals without processor time: 0.11 per second in the quiet runs, 1.1 in the others
    stalls_per_s: float = 0.2
    stall_s: tuple[float, float] = (0.02, 0.09)
    started_behind_s: tuple[float, float] = (0.025, 0.1)  # wait of the first image
    warm_frames: tuple[int, int] = (8, 25)  # the first images, served at the rate of their arrival
    warm_up_frames: float = 8.0  # time constant, in frames, with which service then becomes faster
    buffers: int = 6  # waiting images; more are lost
    in_flight: int = 4  # n_i is the end of the image this many frames earlier


@dataclass(frozen=True)
class Regime:
    """How frames are exposed and delayed. All times in seconds; distributions are Gaussian unless stated otherwise.

    Exposure (mid) of frame k: e_k = t0 + k T (1 + skew) + sum of k steps of trigger_walk_s + u_k; u_k has the
    distribution of the delay if the camera is triggered and is zero in freerun. Delay at reading: delay_s + slow part
    (first-order Gauss-Markov, drift_s, DRIFT_TIME_S) + white part (jitter_s), frames kept in order, read in the next
    cycle. started = e_k - half a frame - offset - white part (offset_s uniform over half a frame, once a trial), kept
    within the frame before mid-exposure. stamped: the camera's own clock, unknown offset and rate, noise stamp_s.
    busy: replaces the distributions of delay and n_i by those of a busy computer, except the slow part of the delay.
    """

    name: str
    drift_s: float = 0.0
    jitter_s: float = 0.0
    triggered: bool = False
    stamped: bool = False
    delay_s: float = 0.074
    delay_prior_s: float = VARIATION_S  # prior standard deviation of the mean delay, for the bound
    skew_ppm: float = 100.0  # largest, uniform; of the frame clock and of the stamps
    trigger_walk_s: float = 0.0
    started_white_s: float = FRAME_S / 4.0
    # largest, uniform: with the white part, the spread of one whole frame
    started_offset_s: float = FRAME_S / 4.0
    stamp_s: float = 5e-5
    busy: Busy | None = None


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
# last, since a regime's index is part of its trials' seeds
REGIMES["live"] = Regime("live", drift_s=0.005, busy=Busy())


def regimes_named(names: list[str] | None) -> list[Regime]:
    """The regimes with those names, or all for None. Raises UserError for an unknown name."""
    for name in names or ():
        if name not in REGIMES:
            raise UserError(f"regime {name!r}: unknown; use one of {', '.join(REGIMES)}")
    return [REGIMES[name] for name in names] if names else list(REGIMES.values())
