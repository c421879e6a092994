"""What one rig truly is, what is done with it, and what its owner believes. SI units."""

from dataclasses import dataclass

TICK_S = 0.001
"""The controller's cycle."""
STEP_S = 0.0001
"""Grid of the motion; every event and dead time falls on it."""


@dataclass(frozen=True)
class Mode:
    """A bending mode. push: the share of a force at the tip that it takes, per unit mass."""

    frequency_hz: float
    damping_ratio: float
    participation: float
    push: float = 1.0


@dataclass(frozen=True)
class Joint:
    """First-order lag behind a dead time. encoder: `noisy` (white), `coarse` (steps of resolution_rad), `none`."""

    bandwidth_hz: float
    dead_time_s: float
    encoder: str
    resolution_rad: float
    noise_rad: float
    speed_noise_rad_s: float


@dataclass(frozen=True)
class Accelerometer:
    """state: `good`, `dead` (a constant from the start) or `none` (no column). age_s: how old a sample is when read.

    colour: correlation of one sample's noise with the next one's.
    """

    state: str
    gain: float
    noise_m_s2: float
    colour: float
    bias_m_s2: float
    range_m_s2: float
    age_s: float


@dataclass(frozen=True)
class Camera:
    """Exposures and the image. stamped: whether images carry the camera's own time."""

    triggered: bool
    frame_rate_hz: float
    rate_error: float
    exposure_s: float
    scale_px_per_m: float
    noise_px: float
    colour: float
    offset_px: float
    stamped: bool


@dataclass(frozen=True)
class Arrivals:
    """When images are read. Lateness = floor + slow walk + a one-sided rest, read in order by one server.

    floor_s: least lateness, of the middle of the exposure. rest_mean_s, rest_shape: of a gamma law. tail_share,
    tail_s: share and scale of a Pareto tail (power 2). walk_s, walk_time_s: spread and time constant of the walk,
    which only adds. stall_rate_hz, stall_s: how often and how long nothing is read. start_stall_s: nothing is read
    before. service_s: least time between two readings. lost_share: images lost by chance. queue: images that wait
    at most; older ones are thrown away (0: as many as come).
    """

    floor_s: float
    rest_mean_s: float
    rest_shape: float
    tail_share: float
    tail_s: float
    walk_s: float
    walk_time_s: float
    stall_rate_hz: float
    stall_s: float
    start_stall_s: float
    service_s: float
    lost_share: float
    queue: int


@dataclass(frozen=True)
class Event:
    """Something that is done with the arm.

    kind   `strike`  impact at the tip that lasts ramp_s (0: no time), size m: the amplitude it gives an arm at rest
           `push`    half a sine of force over ramp_s, size m: force / w^2
           `pull`    force grows over ramp_s, is held for hold_s and let go at once, size m: the static deflection
           `rock`    force at `ratio` times the arm's frequency over hold_s, size m: what it builds up
           `move`    the joint moves by size rad in ramp_s
    """

    kind: str
    at_s: float
    size: float
    ramp_s: float = 0.0
    hold_s: float = 0.0
    ratio: float = 1.0

    @property
    def end_s(self) -> float:
        """When it is over."""
        return self.at_s + self.ramp_s + self.hold_s


@dataclass(frozen=True)
class Belief:
    """The model file's errors: factors of what is true, and what the file says of the delay."""

    frequency: float
    damping: float
    participation: float
    scale: float
    bandwidth: float
    accelerometer_noise: float
    image_noise: float
    bias_m_s2: float
    delay_error_s: float
    delay_spread: float


@dataclass(frozen=True)
class Case:
    """A recording to be made. swinging_m: amplitude at the start; amplitude_m: what events are sized by."""

    seed: int
    kind: str
    duration_s: float
    length_m: float
    modes: tuple[Mode, ...]
    joint: Joint
    accelerometer: Accelerometer
    camera: Camera
    arrivals: Arrivals
    events: tuple[Event, ...]
    belief: Belief
    amplitude_m: float
    swinging_m: float

    @property
    def noise_m(self) -> float:
        """The image's noise at the tip, m."""
        return self.camera.noise_px / self.camera.scale_px_per_m
