"""The table of topics: every message that a recording or the telemetry holds, its fields, its rate and who writes it.

Each name carries its unit as a suffix. A number that is not there is NaN in memory and null in the file. Schemas,
decoders, telemetry and docs/topics.md are made from this table. A field may be added with a default, for recordings
that lack it; any other change goes with stillarm.common.recording.header.FORMAT.
"""

from math import nan
from typing import Annotated

import msgspec

from stillarm.common.datagrams.fields import about

Time = Annotated[float, about("the controller's clock")]
RigTime = Annotated[float, about("the rig's monotonic clock")]
Cycle = Annotated[int, about("the controller's cycle")]


class FastSample(msgspec.Struct, frozen=True, gc=False):
    """/fast, every cycle: what the sensors and the reference gave the controller, and the command it answered
    with.

    Names are those of fast.csv.
    """

    time_s: Time
    cycle: Cycle
    acceleration_m_s2: Annotated[float, about("of the tip, as measured")] = nan
    joint_velocity_command_rad_s: Annotated[float, about("what the drive was sent")] = nan
    joint_velocity_reference_rad_s: Annotated[float, about("the external part of the command")] = nan
    joint_position_rad: Annotated[float, about("as the drive reported")] = nan
    joint_velocity_rad_s: Annotated[float, about("as the drive reported")] = nan
    joint_age_s: Annotated[float, about("age of the drive's report")] = nan
    deflection_m: Annotated[float, about("where measured directly, e.g. by a strain gauge")] = nan
    joint_torque_n_m: Annotated[float, about("as measured")] = nan
    joint_torque_command_n_m: Annotated[float, about("what the drive was told")] = nan
    motor_current_a: Annotated[float, about("as measured")] = nan
    motor_current_command_a: Annotated[float, about("what the amplifier was told")] = nan
    motor_voltage_v: Annotated[float, about("at the motor, or what the amplifier was told")] = nan
    motor_position_rad: Annotated[float, about("before the gear")] = nan
    strain: Annotated[float, about("a strain gauge, in any unit: its scale is not known")] = nan
    damping_allowed: Annotated[bool, about("the operator's permission")] = False
    operator: Annotated[int, about("bits of stillarm.controller.safety.table.Operator")] = 0


class FrameSample(msgspec.Struct, frozen=True, gc=False):
    """/frames, one for each visual sample that the controller read. Names are those of frames.csv."""

    time_s: Time
    cycle: Annotated[int, about("the one that read the sample")]
    frame: Annotated[int, about("counts exposures or arrivals; -1: not counted")]
    received_s: Annotated[float, about("when the controller read it: cycle * cycle_s")]
    started_s: Annotated[float, about("n_i * cycle_s")]
    started_cycle: Annotated[int, about("n_i; -1: not known")]
    status: Annotated[int, about("stillarm.common.datagrams.visual_sample.TrackingStatus; 0: measured")]
    displacement_px: Annotated[float, about("of the static scene, along the image's x axis")] = nan
    displacement_y_px: Annotated[float, about("the same along its y axis")] = nan
    rotation_rad: Annotated[float, about("of the scene, about the image's centre")] = nan
    variance_x_px2: Annotated[float, about("of `displacement_px`")] = nan
    variance_y_px2: Annotated[float, about("of `displacement_y_px`")] = nan
    covariance_xy_px2: Annotated[float, about("of both")] = nan
    variance_rotation_rad2: Annotated[float, about("of `rotation_rad`")] = nan
    captured_s: Annotated[float, about("the camera's own stamp, as mid-exposure, on its own clock")] = nan
    exposure_s: Annotated[float, about("exposure time")] = nan
    features: Annotated[int, about("tracked features")] = 0
    inliers: Annotated[int, about("of these, those that agree with one rigid displacement")] = 0
    restarted: Annotated[bool, about("the first of a new supervisor: displacements have another zero")] = (
        False
    )


class EstimateSample(msgspec.Struct, frozen=True, gc=False):
    """/estimate, every cycle: the configured method's delay and deflection, and the damping part of the command."""

    time_s: Time
    cycle: Cycle
    delay_s: Annotated[float, about("capture delay")]
    delay_std_s: Annotated[float, about("its standard deviation")]
    delay_status: Annotated[str, about("unestimated, estimated, held or invalid")]
    deflection_m: Annotated[float, about("of the tip, at time_s")]
    deflection_std_m: Annotated[float, about("its standard deviation")]
    predicted_deflection_m: Annotated[float, about("when the joint will answer: the drive's lead ahead")]
    damping_rad_s: Annotated[float, about("the damping part of the command")]
    damping_status: Annotated[str, about("active, or why the joint does not damp")]
    state: Annotated[str, about("stillarm.controller.safety.table.State; empty in older recordings")] = ""
    reason: Annotated[str, about("the Event behind the state; empty where nothing is wrong")] = ""
    deflection_status: Annotated[str, about("as delay_status")] = ""
    estimate_reason: Annotated[str, about("why, in words")] = ""
    trust: Annotated[str, about("starting, settled or doubtful; empty in older recordings")] = ""


class LinkSample(msgspec.Struct, frozen=True, gc=False):
    """/link, once a second: counts of the link since the start, the loop's cycles and its missed deadlines."""

    time_s: Time
    cycle: Cycle
    accepted: Annotated[int, about("visual datagrams taken")]
    lost: Annotated[int, about("net number of sequence numbers never seen")]
    duplicate: Annotated[int, about("seen before")]
    late: Annotated[int, about("overtaken by a newer one")]
    malformed: Annotated[int, about("no datagram, or none of the table's messages")]
    forged: Annotated[int, about("wrong tag")]
    foreign_version: Annotated[int, about("of another version of the table")]
    old_session: Annotated[int, about("of a session that was replaced, or answering another's timestamps")]
    unexpected: Annotated[int, about("a message that this socket does not take")]
    sessions: Annotated[int, about("supervisors so far")]
    deadline_misses: Annotated[int, about("cycles that ended late")]
    accelerometer_faults: Annotated[int, about("failed reads")]
    recorder_lost: Annotated[int, about("messages for which the recorder's ring had no room")]
    unproven: Annotated[int, about("well signed, but without an echo of this session")] = 0
    overdue: Annotated[int, about("held up on their way for too long")] = 0
    shed: Annotated[int, about("turned away by the kernel in a flood, or no room for them")] = 0
    send_failures: Annotated[int, about("datagrams that could not be sent")] = 0
    reference_refused: Annotated[int, about("all that the operator's socket did not take")] = 0
    drive_accepted: Annotated[int, about("states of the drive taken")] = 0
    drive_lost: Annotated[int, about("as `lost`")] = 0
    drive_refused: Annotated[int, about("all that the drive's socket did not take")] = 0
    drive_ignored: Annotated[int, about("states that are not finite")] = 0
    drive_tripped: Annotated[int, about("1: the velocity loop has given up a joint that ran away")] = 0
    recorder_alive: Annotated[bool, about("whether the recorder's process runs")] = True
    values_refused: Annotated[
        int, about("of the controller's input, as not plausible; the log names them")
    ] = 0
    supervisor_clock_offset_s: Annotated[float, about("its monotonic clock minus this process's")] = nan
    supervisor_clock_offset_std_s: Annotated[float, about("its standard deviation")] = nan
    supervisor_clock_skew: Annotated[float, about("rate of that clock against this one's, minus one")] = nan
    round_trip_s: Annotated[float, about("both ways, without waits")] = nan


class LoopSample(msgspec.Struct, frozen=True, gc=False):
    """/loop, when the loop ends: how the whole run kept its deadlines. Percentiles of the wake-up's lateness
    and of the time from wake-up to the command, microseconds.
    """

    time_s: Time
    cycles: Annotated[int, about("of the whole run")]
    deadline_misses: Annotated[int, about("cycles that ended late")]
    wakeup_latency_us_p50: Annotated[float, about("lateness of the wake-up, median")]
    wakeup_latency_us_p99: Annotated[float, about("99 %")]
    wakeup_latency_us_p999: Annotated[float, about("99.9 %")]
    wakeup_latency_us_max: Annotated[float, about("the largest")]
    compute_us_p50: Annotated[float, about("from wake-up to command, median")]
    compute_us_p99: Annotated[float, about("99 %")]
    compute_us_p999: Annotated[float, about("99.9 %")]
    compute_us_max: Annotated[float, about("the largest")]


class LogLine(msgspec.Struct, frozen=True, gc=False):
    """/log, on change: what an operator should read, with its remedy."""

    time_s: Time
    level: Annotated[str, about("debug, info, warning or error")]
    text: Annotated[str, about("one line")]


class TrueState(msgspec.Struct, frozen=True):
    """/truth/state, every step of the simulated rig."""

    time_s: RigTime
    joint_position_rad: Annotated[float, about("of the joint")]
    joint_velocity_rad_s: Annotated[float, about("of the joint")]
    joint_acceleration_rad_s2: Annotated[float, about("of the joint")]
    deflection_m: Annotated[float, about("of the tip: sum of the modes")]
    tip_position_m: Annotated[float, about("transverse: length * joint position + deflection")]
    tip_acceleration_m_s2: Annotated[float, about("its second derivative")]
    modal_deflections_m: Annotated[list[float], about("one for each mode")]


class TrueFrame(msgspec.Struct, frozen=True, gc=False):
    """/truth/frames, one for each exposure of the simulated camera: when it truly was, when it was handed over."""

    time_s: RigTime
    frame: Annotated[int, about("counts exposures")]
    mid_exposure_s: Annotated[float, about("its true time")]
    delivered_s: Annotated[float, about("when the image was handed over")]


class ImageSample(msgspec.Struct, frozen=True, gc=False):
    """/images, every frame, in the supervisor's own recording: the image, and what the tracker made of it."""

    time_s: Annotated[float, about("the supervisor's monotonic clock")]
    counter: Annotated[int, about("the camera's own; -1: none")]
    started_cycle: Annotated[int, about("n_i; -1: none")]
    stamp_s: Annotated[float, about("the camera's stamp, on its own clock")]
    exposure_s: Annotated[float, about("exposure time")]
    status: Annotated[int, about("stillarm.common.datagrams.visual_sample.TrackingStatus")]
    displacement_px: Annotated[float, about("along the image's x axis")]
    displacement_y_px: Annotated[float, about("along its y axis")]
    rotation_rad: Annotated[float, about("about its centre")]
    features: Annotated[int, about("tracked features")]
    inliers: Annotated[int, about("of these, those that agree")]
    format: Annotated[str, about("png")]
    data: Annotated[str, about("the image, in base64")]
    lost: Annotated[int, about("images tracked so far for which the recorder's ring had no room")] = 0


class SettingsSample(msgspec.Struct, frozen=True, gc=False):
    """/settings, at a live run's start and whenever an operator asked for a change: what is in force from then on."""

    time_s: Time
    cycle: Annotated[int, about("the controller's cycle, which read what was asked")]
    method: Annotated[str, about("in force")]
    added_damping_ratio: Annotated[float, about("in force")]
    asked_method: Annotated[str, about("what the operator asked for; empty: no other one")] = ""
    asked_added_damping_ratio: Annotated[float, about("what the operator asked for; null: no other one")] = (
        nan
    )
    refused: Annotated[str, about("why it was refused; empty: it was not")] = ""


class PairSample(msgspec.Struct, frozen=True, gc=False):
    """/pair: imported data of one input and one output, in their own units."""

    time_s: Annotated[float, about("row / rate")]
    input: Annotated[float, about("in the file's own unit")]
    output: Annotated[float, about("in the file's own unit")]


class ForeignColumns(msgspec.Struct, frozen=True):
    """/fast/columns and /frames/columns: what an imported row held in columns that are not known, as it was
    given.

    One message for each row of the file, in its order.
    """

    time_s: Time
    columns: Annotated[dict[str, float | str | None], about("a number, a text, or null for an empty field")]


class Topic(msgspec.Struct, frozen=True):
    """A topic: its name in the file, its message type, how often it comes, and who writes it."""

    name: str
    message: type[msgspec.Struct]
    rate: str
    source: str

    @property
    def every_cycle(self) -> bool:
        """Whether the controller's loop makes one each cycle."""
        return self.rate == _EVERY_CYCLE

    @property
    def short_name(self) -> str:
        """The name in tables' files and telemetry: truth_state for /truth/state."""
        return self.name.strip("/").replace("/", "_")


_EVERY_CYCLE = "every cycle"
TOPICS = (
    Topic("/fast", FastSample, _EVERY_CYCLE, "controller"),
    Topic("/frames", FrameSample, "every frame", "controller"),
    Topic("/estimate", EstimateSample, _EVERY_CYCLE, "controller"),
    Topic("/link", LinkSample, "1 Hz", "controller"),
    Topic("/loop", LoopSample, "when the loop ends", "controller"),
    Topic("/log", LogLine, "on change", "controller, rig"),
    Topic("/truth/state", TrueState, "every step of the rig", "rig"),
    Topic("/truth/frames", TrueFrame, "every exposure", "rig"),
    Topic("/images", ImageSample, "every frame, with --record-images", "supervisor"),
    Topic("/pair", PairSample, "every sample", "import"),
    Topic(
        "/fast/columns", ForeignColumns, "every row, where an imported fast.csv has unknown columns", "import"
    ),
    Topic(
        "/frames/columns",
        ForeignColumns,
        "every row, where an imported frames.csv has unknown columns",
        "import",
    ),
    Topic("/settings", SettingsSample, "at the start, and when an operator asks", "controller"),
)
TOPIC_INDEX = {topic.name: index for index, topic in enumerate(TOPICS)}
