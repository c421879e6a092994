"""Checks machine, bus, sensor, camera, link and drive, in that order. Gathers facts, judges them, moves nothing."""

from collections.abc import Iterator
from math import nan
from pathlib import Path

from stillarm.common.files.configuration import (
    Configuration,
    load_assumed_model,
    load_configuration,
    model_path,
)
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer
from stillarm.drivers.buses.i2c import MEMORY_PREFIX
from stillarm.drivers.drives.drive_factory import probe_drive
from stillarm.extras import missing_package
from stillarm.preflight.camera import CameraFacts, judge_camera, watch_camera
from stillarm.preflight.drive import judge_drive, judge_torque
from stillarm.preflight.link import (
    LinkFacts,
    ask_itself,
    ask_supervisor,
    is_here,
    judge_key,
    judge_link,
    port_is_free,
)
from stillarm.preflight.machine import judge_machine, look_at_machine
from stillarm.preflight.sensor import (
    could_not_start,
    declared_bus_hz,
    judge_bus,
    judge_pause,
    judge_sensor,
    read_sensor,
)
from stillarm.preflight.step_time import check_step
from stillarm.preflight.verdict import Verdict, fail, ok, warn

SENSOR_S, CAMERA_S, LINK_S, DRIVE_S = 0.6, 1.5, 1.5, 0.3


def walk(path: Path) -> Iterator[Verdict]:
    """Yield the verdicts one by one. Raises UserError for a configuration or model that cannot be read."""
    configuration = load_configuration(path)
    model = load_assumed_model(configuration, path)
    yield from judge_machine(look_at_machine(), emulated=is_emulated(configuration))
    link = configuration.link
    controls, sees = is_here(link.controller_host), is_here(link.supervisor_host)
    busy = controls and not port_is_free(link.controller_host, link.controller_port)
    if controls and not busy:
        yield check_step(model, configuration.controller, str(model_path(configuration, path)))
    if busy:  # setting up the sensor would disturb the controller
        yield warn("sensor", "not checked while a controller runs (see link)")
    elif controls:
        yield from look_at_sensor(configuration, model)
    else:
        yield ok("sensor", f"connected to {link.controller_host}: run this command there, too")
    key, verdict = judge_key(link)
    facts: LinkFacts | None = None
    refused: Verdict | None = None
    supervisor_runs = not sees or not port_is_free(link.supervisor_host, link.supervisor_port)
    if key is not None and controls:
        try:
            facts = (
                ask_supervisor(configuration, key, LINK_S, model.timing.cycle_s)
                if supervisor_runs
                else ask_itself(configuration, key)
            )
        except UserError as error:
            refused = fail("link", f"{error} (does a controller run? stop it for the check)")
    yield from _camera(configuration, model, facts, here=sees, supervisor_runs=supervisor_runs)
    yield verdict
    if facts is not None:
        yield judge_link(facts, link)
    elif refused is not None:
        yield refused
    yield from judge_torque(model, str(model_path(configuration, path)))
    if not controls or configuration.drive.driver == "none":
        yield ok("drive", "none here")
    elif key is None:
        yield warn("drive", "not checked without a key")
    elif refused is not None:
        yield warn("drive", "not checked while another process holds the controller's port")
    else:
        yield from look_at_drive(configuration, model, key)


def is_emulated(configuration: Configuration) -> bool:
    """Whether the rig is simulated."""
    return configuration.camera.driver == "shared_memory" or configuration.accelerometer.bus.startswith(
        MEMORY_PREFIX
    )


def look_at_sensor(configuration: Configuration, model: Model) -> Iterator[Verdict]:
    """Check bus and sensor."""
    device = configuration.accelerometer
    try:
        accelerometer = open_accelerometer(device, wait_s=1.0)
        if accelerometer is None:
            yield ok("sensor", "none configured")
            return
        accelerometer.start()
    except UserError as error:
        yield could_not_start(error)
        return
    try:
        facts = read_sensor(accelerometer, model.timing.cycle_s, SENSOR_S)
        if (pause := judge_pause(facts)) is not None:
            yield pause
            facts = read_sensor(accelerometer, model.timing.cycle_s, SENSOR_S)
    finally:
        accelerometer.close()
    if device.bus.startswith("/dev/i2c-") and device.driver not in _SERIAL:
        yield judge_bus(device.bus, declared_bus_hz(device.bus), facts.fastest_read_s, model.timing.cycle_s)
    else:
        yield ok("bus", f"not an I2C bus of this computer; a read takes {1e6 * facts.fastest_read_s:.0f} us")
    yield from judge_sensor(facts, device, model)


def _camera(
    configuration: Configuration, model: Model, link: LinkFacts | None, *, here: bool, supervisor_runs: bool
) -> Iterator[Verdict]:
    """Check the camera by its images if it is connected here and free; otherwise by its supervisor's data."""
    if not supervisor_runs and here:
        yield from look_at_camera(configuration, model)
    elif link is not None and link.samples:
        images = [(arrived, sample) for arrived, sample in link.samples if sample.frame >= 0]
        facts = CameraFacts(
            tuple(arrived for arrived, _ in images), tuple(sample for _, sample in images), nan, counted=True
        )
        yield from judge_camera(facts, configuration.camera, model)
    else:
        yield warn("camera", "not checked: its supervisor does not answer (see link)")


def look_at_camera(configuration: Configuration, model: Model) -> Iterator[Verdict]:
    """Open the camera and watch it."""
    try:
        import cv2  # not above: a controller's computer has none, and its camera is elsewhere

        from stillarm.drivers.cameras.camera_factory import open_camera
    except ModuleNotFoundError as error:
        yield fail("camera", str(missing_package(error) or error))
        return
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    camera = open_camera(configuration.camera, configuration.supervisor.cycles_in_flight)
    try:
        camera.start()
    except UserError as error:
        yield fail("camera", str(error))
        return
    try:
        facts = watch_camera(camera, configuration.supervisor.tracker, CAMERA_S)
    finally:
        camera.close()
    yield from judge_camera(facts, configuration.camera, model)


def look_at_drive(configuration: Configuration, model: Model, key: bytes) -> Iterator[Verdict]:
    """Ask the drive for its identity and position."""
    try:
        probe = probe_drive(configuration.drive, key, DRIVE_S, model.drive.kind)
    except UserError as error:
        yield fail("drive", str(error))
        return
    yield from judge_drive(probe, configuration.drive, model)


_SERIAL = ("witmotion", "xsens", "vectornav", "microcontroller", "iio")
