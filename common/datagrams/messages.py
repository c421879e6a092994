"""The table of messages between controller, supervisor, drive gateway and operator.

Each class is one kind of datagram. Its tag is the kind's number, its fields are the body in the order of the wire, and
their types are what is checked on arrival. A name's suffix is its unit. Packing and checking
(common/datagrams/datagram.py), the
kernel's filter (common/link/flood_filter.py), the emulated gateway and the tables of docs/protocol.md are
made from here.
"""

from typing import Annotated

import msgspec
from msgspec import Meta

from stillarm.common.datagrams.fields import about

VERSION = 2
"""Of the whole table. Goes up with any change of a field: a receiver of another version refuses the datagram."""

Cycle = Annotated[int, Meta(ge=0)]
Velocity = Annotated[float, Meta(gt=-1e6, lt=1e6)]


class Message(msgspec.Struct, frozen=True, gc=False):
    """A body. A number that is not there is NaN; an integer is taken for a float."""


class Timestamp(Message, frozen=True, tag=1):
    """controller to supervisor, in each cycle."""

    cycle: Annotated[Cycle, about("n_c, the controller's cycle")]
    sent_s: Annotated[float, about("when it left, on the controller's monotonic clock")]


class Visual(Message, frozen=True, tag=2):
    """supervisor to controller, for each frame: a VisualSample (common/datagrams/visual_sample.py) and times."""

    timestamp_session: Annotated[int, about("session of the timestamp n_i")]
    frame: Annotated[int, about("counter of exposures if the camera has one, else of arrivals; -1: no image")]
    started_cycle: Annotated[
        int, about("n_i, the latest timestamp as the supervisor's cycle began; -1: none")
    ]
    status: Annotated[int, about("stillarm.common.datagrams.visual_sample.TrackingStatus; 0: measured")]
    displacement_x_px: Annotated[float, about("of the static scene, at the image's centre")]
    displacement_y_px: Annotated[float, about("the same, down the image")]
    rotation_rad: Annotated[float, about("the same, about the image's centre")]
    variance_x_px2: Annotated[float, about("of `displacement_x_px`")]
    variance_y_px2: Annotated[float, about("of `displacement_y_px`")]
    covariance_xy_px2: Annotated[float, about("of both")]
    variance_rotation_rad2: Annotated[float, about("of `rotation_rad`")]
    captured_s: Annotated[float, about("the camera's own stamp, as mid-exposure, on its own clock")]
    exposure_s: Annotated[float, about("exposure time")]
    features: Annotated[int, about("tracked features")]
    inliers: Annotated[int, about("of these, those that agree with one rigid displacement")]
    sent_s: Annotated[float, about("`sent_s` of the latest timestamp")]
    received_s: Annotated[float, about("when that was read, on the supervisor's monotonic clock")]
    answered_s: Annotated[float, about("when this left, on the same clock")]


class DriveCommand(Message, frozen=True, tag=3):
    """controller to drive gateway, in each cycle."""

    velocity_rad_s: Annotated[float, about("of the joint; a command that is not finite is ignored")]


class DriveState(Message, frozen=True, tag=4):
    """drive gateway to controller, about once a millisecond."""

    position_rad: Annotated[float, about("of the joint; a state that is not finite is ignored")]
    velocity_rad_s: Annotated[float, about("of the joint")]
    status: Annotated[int, about("stillarm.drivers.drives.drive_gateway.GatewayStatus")]
    command_sequence: Annotated[int, about("sequence of the newest command accepted")]


class Reference(Message, frozen=True, tag=5):
    """operator to controller (`link.reference_port`); lapses after 0.1 s."""

    velocity_rad_s: Annotated[Velocity, about("joint velocity reference")]
    damping_allowed: Annotated[bool, about("whether the joint may damp")]


class Hello(Message, frozen=True, tag=6):
    """gateway or controller, to who addressed it without its session; the head tells all."""


class OperatorCommand(Message, frozen=True, tag=7):
    """operator to controller (`link.reference_port`): arm, disarm, clear, stop."""

    bits: Annotated[int, Meta(gt=0, lt=16), about("stillarm.controller.safety.table.Operator")]


class Adjustment(Message, frozen=True, tag=8):
    """operator to controller (`link.reference_port`): another method or gain, within `controller.adjustable`."""

    method: Annotated[str, Meta(max_length=64), about("as in `controller.method`; empty: as it is")]
    added_damping_ratio: Annotated[float, about("as in `controller.damping`; NaN: as it is")]


class DriveInput(Message, frozen=True, tag=9):
    """controller to drive gateway, in each cycle, in place of DRIVE_COMMAND where the drive obeys a torque, a current
    or a voltage."""

    input: Annotated[float, about("N m, A or V, as `drive.kind` of the model says; not finite: brake")]


MESSAGES: tuple[type[Message], ...] = (
    Timestamp,
    Visual,
    DriveCommand,
    DriveState,
    Reference,
    Hello,
    OperatorCommand,
    Adjustment,
    DriveInput,
)
