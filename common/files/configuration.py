"""The configuration file: one TOML file for both computers; each daemon reads the sections that concern it."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from stillarm.common.files.model import Model, load_model
from stillarm.common.files.typed_toml import load_toml
from stillarm.common.user_error import UserError

Port = Annotated[int, Meta(ge=1, le=65535)]
Positive = Annotated[float, Meta(gt=0.0)]
NonNegative = Annotated[float, Meta(ge=0.0)]
Fraction = Annotated[float, Meta(ge=0.0, le=1.0)]
AccelerometerDriver = Literal[
    "lis3lv02dq", "lis3dh", "adxl345", "adxl355", "mpu6050", "icm20948",
    "witmotion", "xsens", "vectornav", "microcontroller", "iio", "none",
]  # fmt: skip


class Link(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Where the two processes listen, and the key that signs what they send. An empty key_file: the demo key."""

    controller_host: str = "127.0.0.1"
    controller_port: Port = 47001
    supervisor_host: str = "127.0.0.1"
    supervisor_port: Port = 47002
    reference_port: Port = 47003
    key_file: str = ""
    max_datagrams_per_cycle: Annotated[int, Meta(ge=1, le=256)] = 32


class Correlation(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Delay by recursive cross-correlation (eq. 11): M = window_s / cycle, rho = forgetting, search around
    the prior.
    """

    window_s: Positive = 1.0
    forgetting: Annotated[float, Meta(gt=0.0, lt=1.0)] = 0.5
    search_periods: Annotated[float, Meta(gt=0.0, le=0.5)] = 0.4
    min_correlation: Fraction = 0.5
    min_amplitude_m: NonNegative = 0.0003


class Regression(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """On-line sine regression over a window of 3 to 20 frames.

    form: "simplified" takes the model's frequency, "exact" fits it, within frequency_std_fraction of the model's.
    variable_window: whether a sample that breaks with the fit cuts the window down to itself.
    """

    frames: Annotated[int, Meta(ge=3, le=20)] = 20
    offset_time_s: Positive = 3.0
    form: Literal["simplified", "exact"] = "simplified"
    frequency_std_fraction: Annotated[float, Meta(gt=0.0, le=0.3)] = 0.05
    variable_window: bool = True


class Kalman(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The Kalman filters. Disturbances are white accelerations, given by their level per millisecond sample.

    disturbance_m_s2: of each mode; imposed_motion_m_s2: of the slow motion that nobody reports (drift of the image)
    fusion_sensor: what kalman_fusion takes beside the camera; fusion_delay: what dates the camera's samples there
    strain_noise_m: of a deflection measured by a strain gauge, in one cycle
    """

    disturbance_m_s2: Annotated[float, Meta(gt=0.0, le=100.0)] = 0.2
    imposed_motion_m_s2: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.001
    fusion_sensor: Literal["accelerometer", "strain_gauge"] = "accelerometer"
    fusion_delay: Literal["timestamps", "model"] = "timestamps"
    strain_noise_m: Annotated[float, Meta(gt=0.0, le=0.1)] = 0.0001


class Fused(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Our own method. Relative spread of the modes' frequencies before they are seen, and their walk in a square root
    second; disturbance_share: how much of its amplitude the vibration changes unseen in a square root second.
    """

    frequency_spread: Positive = 0.02
    frequency_walk: Positive = 0.00001
    disturbance_share: Positive = 0.0005
    min_amplitude_m: NonNegative = 0.0003
    known_within_s: Positive = 0.005


class Damping(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Damping by the joint. `without_schedule`: whether it may act where no schedule says when.

    law: "velocity", proportional to the deflection ahead; or "composite", fast feedback of deflection and rate with
    slow feedback of the image.
    """

    law: Literal["velocity", "composite"] = "velocity"
    without_schedule: bool = True
    added_damping_ratio: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.12
    return_time_s: Positive = 4.0
    max_velocity_rad_s: Positive = 0.2
    stale_after_s: Annotated[float, Meta(gt=0.0, le=0.15)] = 0.1
    fade_s: Annotated[float, Meta(gt=0.0, le=0.05)] = 0.04


class Dither(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A small sine of the joint that dates the camera's images after the accelerometer's death, while damping is on.

    amplitude_rad bounds the joint's departure. fade_s: how long it takes to rise and to fall.
    """

    enabled: bool = False
    amplitude_rad: Annotated[float, Meta(gt=0.0, le=0.02)] = 0.002
    frequency_hz: Annotated[float, Meta(gt=0.0, le=20.0)] = 1.0
    fade_s: Annotated[float, Meta(ge=0.5, le=30.0)] = 3.0


class Safety(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What must hold before the joint may move, and the emergency stop. docs/safety.md has the states.

    checks_before_arming: besides those that cannot be skipped. Damping waits for images in any case.
    emergency_stop_input: a file whose first byte says it, such as a GPIO's value in /sys; empty: none.
    emergency_stop_value: the byte that stops. A file that cannot be read stops, too.
    """

    checks_before_arming: tuple[Literal["vision", "accelerometer"], ...] = ()
    emergency_stop_input: str = ""
    emergency_stop_value: Annotated[str, Meta(pattern="^[0-9A-Za-z]$")] = "1"


class Adjustable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What an operator may change while the controller runs (`stillarm operate gain`, `method`, and the panel).

    methods: that may take the place of controller.method, and back. max_added_damping_ratio: the greatest gain; where
    the configured one is greater, that one. docs/safety.md says in which states.
    """

    methods: tuple[str, ...] = ("timestamps", "correlation", "fused")
    max_added_damping_ratio: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.2


class Controller(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The 1 ms cycle. reference_shaping: how the external reference is shaped so as not to excite the first mode.

    arm_at_start: whether the joint may move without an operator's `stillarm operate arm`. The default is no: nothing
    moves before a person or the file has said so.
    """

    method: str = "fused"
    arm_at_start: bool = False
    schedule: str = ""
    reference_shaping: Literal["none", "zv", "zvd"] = "none"
    correlation: Correlation = Correlation()
    regression: Regression = Regression()
    kalman: Kalman = Kalman()
    fused: Fused = Fused()
    damping: Damping = Damping()
    dither: Dither = Dither()
    safety: Safety = Safety()
    adjustable: Adjustable = Adjustable()


class Tracker(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Feature tracking against a key frame."""

    features: Annotated[int, Meta(ge=8, le=1000)] = 100
    window_px: Annotated[int, Meta(ge=5, le=101)] = 21
    levels: Annotated[int, Meta(ge=0, le=6)] = 3
    min_inliers: Annotated[int, Meta(ge=3)] = 12
    forward_backward_px: Positive = 0.5
    blur_sigma_px: NonNegative = 0.0


class Supervisor(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Frame capture and tracking. `cycles_in_flight`: how many images are asked for ahead (buffers queued)."""

    cycles_in_flight: Annotated[int, Meta(ge=1, le=32)] = 1
    tracker: Tracker = Tracker()


class AccelerometerDevice(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Which accelerometer hangs where.

    bus, address: of an I2C part; /dev/i2c-N, or memory:NAME for an emulator's registers in shared memory; address 0:
    the part's usual one. port, baud: of a serial one; pty:NAME for an emulator; baud 0: the device's usual one.
    device: of a Linux IIO one, its name or iio:deviceN.
    axis, sign: the measured acceleration is sign times the one along the arm's `axis`; rotation_deg: how the sensor
    is turned in its mount, about the arm's x, then y, then z. bias_m_s2: taken off every reading.
    bandwidth_hz: which of the part's filters; 0: its default. full_scale_g: where the driver can set it.
    """

    driver: AccelerometerDriver = "lis3lv02dq"
    bus: str = "/dev/i2c-1"
    address: Annotated[int, Meta(ge=0, le=0x77)] = 0
    port: str = "/dev/ttyACM0"
    baud: Annotated[int, Meta(ge=0, le=12_000_000)] = 0
    device: str = "iio:device0"
    axis: Literal["x", "y", "z"] = "y"
    sign: Literal[1, -1] = 1
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    full_scale_g: Literal[2, 4, 6, 8, 16] = 2
    bandwidth_hz: NonNegative = 0.0
    bias_m_s2: float = 0.0


class CameraDevice(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Which camera. device: for opencv a number, path or URL; for file a video, a folder of images or a .cih; for
    shared_memory a NAME; for the others a serial number, or a place in the list, from 0.

    width_px, height_px, exposure_s, frame_rate_hz: 0 leaves the camera's own; so does a negative gain, which is in the
    camera's own unit. buffers: how many images the driver holds; 0: one for opencv, four for others. trigger:
    "software", one image for each that is asked for; "line", the camera's first input. stamp_reference: what the
    camera's stamp dates; "auto": as its driver knows. producer: GenICam's transport layer, a .cti file.
    """

    driver: Literal[
        "opencv",
        "file",
        "shared_memory",
        "basler",
        "genicam",
        "aravis",
        "ids_peak",
        "ueye",
        "libcamera",
    ] = "opencv"
    device: str = "0"
    width_px: Annotated[int, Meta(ge=0)] = 0
    height_px: Annotated[int, Meta(ge=0)] = 0
    exposure_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    gain: Annotated[float, Meta(ge=-1.0, le=10_000.0)] = -1.0
    frame_rate_hz: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0
    buffers: Annotated[int, Meta(ge=0, le=64)] = 0
    trigger: Literal["freerun", "software", "line"] = "freerun"
    stamp_reference: Literal["auto", "exposure_start", "mid_exposure", "exposure_end", "transfer_end"] = (
        "auto"
    )
    producer: str = ""


class OdriveDevice(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """An ODrive's ASCII protocol. port: a serial device, or pty:NAME for an emulator's; axis: motor 0 or 1.

    baud: without effect over USB; a UART needs at least 460800 for one command and one report each millisecond.
    """

    port: str = "/dev/ttyACM0"
    baud: Annotated[int, Meta(ge=9600, le=12_000_000)] = 921600
    axis: Literal[0, 1] = 0


class Cia402Device(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A CiA 402 drive on a CAN bus. interface, channel: as python-can names them; bitrate: where the interface sets it.

    mode: 3 profile velocity, 9 cyclic synchronous velocity. velocity_units_s_per_turn: what 60FF and 606C hold for a
    motor that turns once a second; position_units_per_turn: what 6064 counts in a turn of the motor.
    """

    interface: str = "socketcan"
    channel: str = "can0"
    bitrate: Annotated[int, Meta(ge=10_000, le=1_000_000)] = 1_000_000
    node: Annotated[int, Meta(ge=1, le=126)] = 1
    mode: Literal[3, 9] = 9
    velocity_units_s_per_turn: Positive = 4096.0
    position_units_per_turn: Positive = 4096.0


class Mcp4725Device(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A 12-bit DAC whose voltage is the motor's velocity. bus: /dev/i2c-N, or memory:NAME for an emulator's.

    supply_v: voltage of code 4096; zero_v: voltage at which the motor stands; turns_s_per_v: the motor's velocity,
    signed, for each volt above that.
    """

    bus: str = "/dev/i2c-1"
    address: Annotated[int, Meta(ge=0x60, le=0x67)] = 0x62
    supply_v: Annotated[float, Meta(ge=2.7, le=5.5)] = 5.0
    zero_v: Annotated[float, Meta(ge=0.0, le=5.5)] = 2.5
    turns_s_per_v: Annotated[float, Meta(ge=-1000.0, le=1000.0)] = 0.05


class DriveDevice(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Which drive. gear_ratio: turns of the motor for one of the joint, negative where they turn opposite ways; a
    gateway speaks of the joint itself and has none.
    """

    driver: Literal["udp_gateway", "odrive", "cia402", "mcp4725", "none"] = "udp_gateway"
    gear_ratio: Annotated[float, Meta(ge=-10_000.0, le=10_000.0)] = 1.0
    gateway_host: str = "127.0.0.1"
    gateway_port: Port = 47010
    local_host: str = "127.0.0.1"
    local_port: Port = 47011
    odrive: OdriveDevice = OdriveDevice()
    cia402: Cia402Device = Cia402Device()
    mcp4725: Mcp4725Device = Mcp4725Device()


class SimulatedScene(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What the simulated camera looks at and how."""

    width_px: Annotated[int, Meta(ge=64, le=4096)] = 640
    height_px: Annotated[int, Meta(ge=64, le=4096)] = 480
    noise_grey_levels: NonNegative = 2.0
    buffers: Annotated[int, Meta(ge=2, le=64)] = 8
    stamped: bool = False


class Rig(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The stand-in for the hardware. `model` holds its true parameters; empty: the model that the controller
    assumes.
    """

    model: str = ""
    scenario: str = "demo"
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 0
    delay_wander_fraction: Fraction = 0.9
    delay_wander_time_s: Positive = 2.0
    scene: SimulatedScene = SimulatedScene()


class Telemetry(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The live view (docs/telemetry.md): msgpack by UDP to host:port, unsigned. every_cycles: 1 sends each cycle.

    panel_port: where `stillarm panel` listens on the same host, so that PlotJuggler can have `port` meanwhile.
    view_rate_hz: how many reduced images a second the supervisor sends to the panel; 0: none.
    """

    enabled: bool = True
    host: str = "127.0.0.1"
    port: Port = 9870
    panel_port: Port = 9871
    view_rate_hz: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.0
    period_s: Annotated[float, Meta(ge=0.02, le=0.05)] = 0.03
    every_cycles: Annotated[int, Meta(ge=1, le=1000)] = 1


class Configuration(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The whole file. `model`: the model file that the controller assumes, relative to this file."""

    model: str = "model.toml"
    link: Link = Link()
    controller: Controller = Controller()
    supervisor: Supervisor = Supervisor()
    accelerometer: AccelerometerDevice = AccelerometerDevice()
    camera: CameraDevice = CameraDevice()
    drive: DriveDevice = DriveDevice()
    rig: Rig = Rig()
    telemetry: Telemetry = Telemetry()


def is_simulated_rig(configuration: Configuration) -> bool:
    """Whether the simulated rig stands in for the hardware: it alone has such a camera."""
    return configuration.camera.driver == "shared_memory"


def default_configuration_path() -> Path:
    """configs/default.toml as it came with the program."""
    return Path(__file__).parents[2] / "configs" / "default.toml"


def load_configuration(path: str | Path) -> Configuration:
    """Read a configuration; the files that it names lie relative to it, wherever the program was started.

    Raises UserError in one line naming file, key, value and what is allowed.
    """
    configuration = _with_files_beside(load_toml(path, Configuration), Path(path).parent)
    link = configuration.link
    if (link.controller_host, link.controller_port) == (link.supervisor_host, link.supervisor_port):
        raise UserError(
            f"{path}: link.supervisor_port = {link.supervisor_port}: the same address as "
            "the controller's; choose another"
        )
    if configuration.drive.gear_ratio == 0.0:
        raise UserError(
            f"{path}: drive.gear_ratio = 0: turns of the motor for one of the joint are needed, 1 for none"
        )
    return configuration


def _with_files_beside(configuration: Configuration, folder: Path) -> Configuration:
    """The configuration with its scenario files, key file and camera file found from `folder`."""
    replace = msgspec.structs.replace
    link, controller, rig, camera = (
        configuration.link,
        configuration.controller,
        configuration.rig,
        configuration.camera,
    )
    if link.key_file:
        link = replace(link, key_file=str(folder / Path(link.key_file).expanduser()))
    if controller.schedule.endswith(".toml"):
        controller = replace(controller, schedule=str(folder / controller.schedule))
    if rig.scenario.endswith(".toml"):
        rig = replace(rig, scenario=str(folder / rig.scenario))
    if camera.driver == "file" and camera.device:
        camera = replace(camera, device=str(folder / Path(camera.device).expanduser()))
    return replace(configuration, link=link, controller=controller, rig=rig, camera=camera)


def model_path(configuration: Configuration, path: str | Path) -> Path:
    """The assumed model file's place, relative to the configuration file at `path`."""
    return Path(path).parent / configuration.model


def load_assumed_model(configuration: Configuration, path: str | Path) -> Model:
    """The model that the controller assumes."""
    return load_model(model_path(configuration, path))


def load_true_model(configuration: Configuration, path: str | Path) -> Model:
    """The model that the simulated rig obeys."""
    return load_model(true_model_path(configuration, path))


def true_model_path(configuration: Configuration, path: str | Path) -> Path:
    """That model's file, relative to the configuration file at `path`."""
    return Path(path).parent / (configuration.rig.model or configuration.model)
