"""The table of topics: every message that a recording holds, its fields with their units, and its rate.

Times are seconds on the controller's clock (cycle * cycle_s), except in the truth file, where they are the
rig's monotonic clock; the controller's recording holds `origin_monotonic_s`, the monotonic time of its cycle
0. A number that is not there is NaN in memory and null in the file.
"""

from math import nan

import msgspec


class FastSample(msgspec.Struct, frozen=True, gc=False):
    """/fast, every cycle: what the sensors and the reference gave the controller, and the command it answered
    with.

    Names are those of fast.csv. joint_age_s: age of the drive's report. damping_allowed: the operator's
    permission. operator: bits of controller.states.table.Operator.
    """

    time_s: float
    cycle: int
    acceleration_m_s2: float = nan
    joint_velocity_command_rad_s: float = nan
    joint_velocity_reference_rad_s: float = nan
    joint_position_rad: float = nan
    joint_velocity_rad_s: float = nan
    joint_age_s: float = nan
    deflection_m: float = nan
    joint_torque_n_m: float = nan
    damping_allowed: bool = False
    operator: int = 0


class FrameSample(msgspec.Struct, frozen=True, gc=False):
    """/frames, one for each visual sample that the controller read. Names are those of frames.csv.

    cycle: the one that read it; received_s = cycle * cycle_s. started_cycle: n_i; started_s = n_i * cycle_s.
    status: common.visual_sample.TrackingStatus. displacement_px is the image's x axis. restarted: the first of a
    supervisor that was started anew, from which on displacements have another zero.
    """

    time_s: float
    cycle: int
    frame: int
    received_s: float
    started_s: float
    started_cycle: int
    status: int
    displacement_px: float = nan
    displacement_y_px: float = nan
    rotation_rad: float = nan
    variance_x_px2: float = nan
    variance_y_px2: float = nan
    covariance_xy_px2: float = nan
    variance_rotation_rad2: float = nan
    captured_s: float = nan
    exposure_s: float = nan
    features: int = 0
    inliers: int = 0
    restarted: bool = False


class EstimateSample(msgspec.Struct, frozen=True, gc=False):
    """/estimate, every cycle: the configured method's delay and deflection, and the damping part of the
    command.

    deflection_m is that at time_s; predicted_deflection_m that at which the joint will answer (drive's lead).
    delay_status, deflection_status: unestimated, estimated, held or invalid; estimate_reason: why, in words.
    state: controller.states.table.State; reason: the Event behind it, empty where nothing is wrong. Both are empty in
    recordings that are older than the states. trust: starting, settled or doubtful; empty in older recordings.
    """

    time_s: float
    cycle: int
    delay_s: float
    delay_std_s: float
    delay_status: str
    deflection_m: float
    deflection_std_m: float
    predicted_deflection_m: float
    damping_rad_s: float
    damping_status: str
    state: str = ""
    reason: str = ""
    deflection_status: str = ""
    estimate_reason: str = ""
    trust: str = ""


class LinkSample(msgspec.Struct, frozen=True, gc=False):
    """/link, once a second: counts of the link since the start, the loop's cycles and its missed
    deadlines.

    unproven, overdue: common.peer.LinkCounts. shed: datagrams that the kernel turned away in a flood, or had no
    room for.
    reference_*, drive_*: the same of the operator's and the drive's sockets; refused: all that was not taken.
    values_refused: of the controller's input, as not plausible; the log names the fields.
    supervisor_clock_*: the supervisor's monotonic clock minus this process's; round_trip_s: both ways, waits left out.
    """

    time_s: float
    cycle: int
    accepted: int
    lost: int
    duplicate: int
    late: int
    malformed: int
    forged: int
    foreign_version: int
    old_session: int
    unexpected: int
    sessions: int
    deadline_misses: int
    accelerometer_faults: int
    recorder_lost: int
    unproven: int = 0
    overdue: int = 0
    shed: int = 0
    send_failures: int = 0
    reference_refused: int = 0
    drive_accepted: int = 0
    drive_lost: int = 0
    drive_refused: int = 0
    drive_ignored: int = 0
    recorder_alive: bool = True
    values_refused: int = 0
    supervisor_clock_offset_s: float = nan
    supervisor_clock_offset_std_s: float = nan
    supervisor_clock_skew: float = nan
    round_trip_s: float = nan


class LoopSample(msgspec.Struct, frozen=True, gc=False):
    """/loop, when the loop ends: how the whole run kept its deadlines. Percentiles of the wake-up's lateness
    and of the time from wake-up to the command, microseconds.
    """

    time_s: float
    cycles: int
    deadline_misses: int
    wakeup_latency_us_p50: float
    wakeup_latency_us_p99: float
    wakeup_latency_us_p999: float
    wakeup_latency_us_max: float
    compute_us_p50: float
    compute_us_p99: float
    compute_us_p999: float
    compute_us_max: float


class LogLine(msgspec.Struct, frozen=True, gc=False):
    """/log, on change: what an operator should read, with its remedy."""

    time_s: float
    level: str
    text: str


class TrueState(msgspec.Struct, frozen=True):
    """/truth/state, every step of the simulated rig."""

    time_s: float
    joint_position_rad: float
    joint_velocity_rad_s: float
    joint_acceleration_rad_s2: float
    deflection_m: float
    tip_position_m: float
    tip_acceleration_m_s2: float
    modal_deflections_m: list[float]


class TrueFrame(msgspec.Struct, frozen=True, gc=False):
    """/truth/frames, one for each exposure of the simulated camera: when it truly was, when it was handed
    over.
    """

    time_s: float
    frame: int
    mid_exposure_s: float
    delivered_s: float


class ImageSample(msgspec.Struct, frozen=True, gc=False):
    """/images, every frame, in the supervisor's own recording: the image, and what the tracker made of it.

    time_s: the supervisor's monotonic clock. counter: the camera's own, -1 if it has none. data: a PNG in
    base64.
    """

    time_s: float
    counter: int
    started_cycle: int
    stamp_s: float
    exposure_s: float
    status: int
    displacement_px: float
    displacement_y_px: float
    rotation_rad: float
    features: int
    inliers: int
    format: str
    data: str


class PairSample(msgspec.Struct, frozen=True, gc=False):
    """/pair: imported data of one input and one output, in their own units."""

    time_s: float
    input: float
    output: float


class ForeignColumns(msgspec.Struct, frozen=True):
    """/fast/columns and /frames/columns: what an imported row held in columns that are not known, as it was
    given.

    One message for each row of the file, in its order: a number, a text, or null for an empty field.
    """

    time_s: float
    columns: dict[str, float | str | None]


class Topic(msgspec.Struct, frozen=True):
    """A topic: its name in the file, its message type, and how often it comes."""

    name: str
    message: type[msgspec.Struct]
    rate: str


TOPICS = (
    Topic("/fast", FastSample, "every cycle"),
    Topic("/frames", FrameSample, "every frame"),
    Topic("/estimate", EstimateSample, "every cycle"),
    Topic("/link", LinkSample, "1 Hz"),
    Topic("/loop", LoopSample, "when the loop ends"),
    Topic("/log", LogLine, "on change"),
    Topic("/truth/state", TrueState, "every step of the rig"),
    Topic("/truth/frames", TrueFrame, "every exposure"),
    Topic("/images", ImageSample, "every frame, with --record-images"),
    Topic("/pair", PairSample, "every sample"),
    Topic("/fast/columns", ForeignColumns, "every row, where an imported fast.csv has unknown columns"),
    Topic("/frames/columns", ForeignColumns, "every row, where an imported frames.csv has unknown columns"),
)
TOPIC_INDEX = {topic.name: index for index, topic in enumerate(TOPICS)}
