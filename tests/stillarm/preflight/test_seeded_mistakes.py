"""Each mistake that people make on a first evening is named, and a rig without one passes. In virtual time: the real
drivers and probes, emulated devices, a clock that the test moves.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import (
    AccelerometerDevice,
    CameraDevice,
    Configuration,
    DriveDevice,
    Link,
    Tracker,
)
from stillarm.common.files.model import Model
from stillarm.common.link.free_ports import free_ports
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.cameras.camera import Frame
from stillarm.drivers.drives.drive_gateway import DriveGateway
from stillarm.drivers.drives.drive_gateway_socket import DriveGatewaySocket
from stillarm.drivers.drives.odrive_drive import OdriveDrive
from stillarm.drivers.drives.udp_gateway_drive import greet_gateway
from stillarm.drivers.emulated_chips.shared_registers import Failure
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer
from stillarm.drivers.emulation.odrive_motor import OdriveMotor
from stillarm.drivers.emulation.pty_port import PtyPort
from stillarm.preflight.camera import judge_camera, watch_camera
from stillarm.preflight.drive import judge_drive
from stillarm.preflight.link import ask_supervisor, judge_key, judge_link
from stillarm.preflight.machine import MachineFacts, judge_machine
from stillarm.preflight.sensor import could_not_start, judge_bus, judge_sensor, read_sensor
from stillarm.preflight.verdict import Level, Verdict, fail
from stillarm.supervisor.exchange import SupervisorExchange

CYCLE_S = 0.001

MODEL = Model()
KEY, OTHER_KEY = b"the key of this test", b"another key altogether"


class Clock:
    """A clock that advances during sleep(), and calls registered functions meanwhile."""

    def __init__(self, meanwhile: Callable[[float], None] = lambda seconds: None) -> None:
        self.now = 100.0
        self.meanwhile = meanwhile

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.meanwhile(seconds)


@dataclass
class Sensor:
    """What is mounted, against what the configuration says."""

    mounted: AccelerometerDevice = field(
        default_factory=lambda: AccelerometerDevice(bus="memory:test-preflight", address=0x1D)
    )
    configured: dict[str, object] = field(default_factory=dict)
    failure: Failure = Failure.NONE
    before_start: bool = False
    noise_m_s2: float = 0.5
    gravity: float = 1.0
    read_s: float = 0.0

    def verdicts(self) -> list[Verdict]:
        """Open, read and judge it."""
        device = msgspec.structs.replace(self.mounted, **self.configured)
        rng = np.random.default_rng(1)
        emulated = emulate_accelerometer(self.mounted, CYCLE_S)

        def feel(seconds: float) -> None:
            for _ in range(max(1, round(seconds / CYCLE_S))):
                rest = np.array(sensed_axes(0.0, self.mounted)) * self.gravity
                x, y, z = rest + self.noise_m_s2 * rng.standard_normal(3)
                emulated.publish((x, y, z))

        clock = Clock(feel)
        if self.before_start:
            emulated.inject(self.failure)
        try:
            accelerometer = I2cAccelerometer(
                device, TABLES[device.driver], wait_s=0.2, sleep=clock.sleep, clock=clock
            )
            accelerometer.start()
        except UserError as error:
            emulated.close()
            return [could_not_start(error)]
        emulated.inject(self.failure)
        quick = accelerometer.read

        def slow_read() -> float:
            clock.now += self.read_s
            return quick()

        accelerometer.read = slow_read  # type: ignore[method-assign]
        try:
            facts = read_sensor(accelerometer, CYCLE_S, 0.4, clock=clock, sleep=clock.sleep)
        finally:
            accelerometer.close()
            emulated.close()
        bus = judge_bus("/dev/i2c-1", None, max(facts.fastest_read_s, 0.000233), CYCLE_S)
        return [bus, *judge_sensor(facts, device, MODEL)]


@dataclass
class Camera:
    """A camera on the test's clock that looks at a scene."""

    rate_hz: float = MODEL.camera.frame_rate_hz
    exposure_s: float = MODEL.camera.exposure_s
    light: float = 1.0
    blur_px: float = 0.0
    texture: bool = True
    frozen: bool = False
    counter_stands: bool = False
    frames: int = 10_000
    config: CameraDevice = field(default_factory=lambda: CameraDevice(driver="basler"))

    def verdicts(self) -> list[Verdict]:
        """Watch and judge it."""
        clock = Clock()
        rng = np.random.default_rng(2)
        scene = rng.uniform(60.0, 200.0, (30, 40)) if self.texture else np.full((30, 40), 120.0)
        scene = cv2.resize(scene, (320, 240), interpolation=cv2.INTER_CUBIC)
        if self.blur_px:
            scene = cv2.GaussianBlur(scene, (0, 0), self.blur_px)
        first = np.clip(scene * self.light, 0, 255).astype(np.uint8)
        taken = [0]
        camera = self

        class Taken:
            notes: list[str] = []  # noqa: RUF012

            def read(self, timeout_s: float) -> Frame | None:
                clock.now += 1.0 / camera.rate_hz
                if taken[0] >= camera.frames:
                    return None
                taken[0] += 1
                noisy = first + 2.0 * min(1.0, camera.light) * rng.standard_normal(first.shape)
                image = first if camera.frozen else np.clip(noisy, 0, 255).astype(np.uint8)
                count = 7 if camera.counter_stands else taken[0]
                return Frame(image, count, clock.now - 0.05, camera.exposure_s)

        facts = watch_camera(Taken(), Tracker(), 0.6, clock=clock)  # type: ignore[arg-type]
        return judge_camera(facts, self.config, MODEL)


@dataclass
class Supervised:
    """A supervisor that answers on a port, with a key; the configuration names a port and a key."""

    key: bytes = KEY
    runs: bool = True
    another_port: bool = False

    def verdicts(self) -> list[Verdict]:
        """Ask it and judge."""
        from stillarm.common.link.udp import UdpSocket

        theirs = UdpSocket(("127.0.0.1", 0), "test")
        elsewhere = UdpSocket(("127.0.0.1", 0), "test")
        ours = UdpSocket(("127.0.0.1", 0), "test")
        address = ours.address
        ours.close()
        exchange = SupervisorExchange(self.key, 77, 1)
        frame = [0]

        def answer(seconds: float) -> None:
            if self.runs:
                exchange.take(theirs.drain(64), clock.now)
                exchange.begin_cycles()
                frame[0] += 1
                sample = VisualSample(frame[0], exchange.oldest().cycle, 0, 0.0, 0.0)
                theirs.send(exchange.end_cycle(sample, clock.now), address)

        clock = Clock(answer)
        named = elsewhere.address if self.another_port else theirs.address
        link = Link(controller_port=address[1], supervisor_port=named[1])
        try:
            facts = ask_supervisor(
                Configuration(link=link), KEY, 0.2, CYCLE_S, clock=clock, sleep=clock.sleep
            )
        finally:
            theirs.close()
            elsewhere.close()
        return [judge_link(facts, link)]


@dataclass
class Gateway:
    """A gateway on a port, with a key."""

    key: bytes = KEY
    runs: bool = True
    another_port: bool = False

    def verdicts(self) -> list[Verdict]:
        """Greet it and judge; it must not have taken a command."""
        gateway = DriveGateway(self.key)
        socket = DriveGatewaySocket(gateway, ("127.0.0.1", 0))
        clock = Clock(lambda seconds: socket.poll(clock.now) and None if self.runs else None)
        port = socket.address[1] if not self.another_port else 9
        config = DriveDevice(gateway_port=port, local_port=free_ports(1)[0])
        try:
            probe = greet_gateway(config, KEY, 0.3, clock=clock, sleep=clock.sleep)
            assert gateway.counts.accepted == 0
        except UserError as error:
            return [fail("drive", str(error))]
        finally:
            socket.close()
        return judge_drive(probe, config, MODEL)


@dataclass
class Odrive:
    """An ODrive on a port."""

    turns: float = 0.0
    error: int = 0
    present: bool = True

    def verdicts(self) -> list[Verdict]:
        """Probe it and judge; it must not have been armed."""
        motor = OdriveMotor()
        motor.position_turns = self.turns
        if self.error:
            motor.fail(self.error)
        config = msgspec.convert(
            {"driver": "odrive", "odrive": {"port": "pty:test-preflight-odrive"}}, DriveDevice
        )
        port = PtyPort(config.odrive.port, "test") if self.present else None
        clock = Clock(lambda s: port.write(motor.receive(port.read(), clock.now)) if port else None)
        try:
            probe = OdriveDrive(config, clock=clock, sleep=clock.sleep).probe(0.2)
            assert motor.state == 1 and motor.commands == 0
        except UserError as error:
            return [fail("drive", str(error))]
        finally:
            if port is not None:
                port.close()
        return judge_drive(probe, config, MODEL)


@dataclass
class KeyFile:
    """A key file of some mode and content."""

    mode: int = 0o600
    content: bytes = bytes(range(100, 132))
    folder: Path | None = None

    def verdicts(self) -> list[Verdict]:
        """Load it."""
        assert self.folder is not None
        path = self.folder / "key"
        path.write_bytes(self.content)
        path.chmod(self.mode)
        return [judge_key(Link(key_file=str(path)))[1]]


@dataclass
class Machine:
    """A machine with its privileges."""

    missing: tuple[str, ...] = ()

    def verdicts(self) -> list[Verdict]:
        """Judge it."""
        facts = MachineFacts(self.missing, "6.1", True, frozenset({"performance"}), 4)
        return judge_machine(facts, emulated=False)


UPSIDE_DOWN = AccelerometerDevice(bus="memory:test-preflight", address=0x1D, rotation_deg=(180.0, 0.0, 0.0))
MISTAKES = {
    "swapped axis": (Sensor(configured={"axis": "z"}), "sensor", "accelerometer.axis = 'z' carries"),
    "wrong sign of gravity": (
        Sensor(mounted=UPSIDE_DOWN, configured={"rotation_deg": (0.0, 0.0, 0.0)}),
        "sensor",
        "gravity has the wrong sign",
    ),
    "wrong size of gravity": (Sensor(gravity=0.5), "sensor", "instead of 9.81"),
    "wrong address": (
        Sensor(configured={"address": 0x1C}),
        "sensor",
        "accelerometer.address",
    ),
    "wrong identity": (
        Sensor(failure=Failure.WRONG_IDENTITY, before_start=True),
        "sensor",
        "correct accelerometer.driver or accelerometer.address",
    ),
    "no such bus": (Sensor(configured={"bus": "/dev/i2c-77"}), "sensor", "accelerometer.bus = '/dev/i2c-77'"),
    "100 kHz bus": (Sensor(read_s=0.00093), "bus", "100 kHz"),
    "stuck sensor": (Sensor(failure=Failure.STUCK), "sensor", "stuck"),
    "sensor that came loose": (Sensor(failure=Failure.NAK), "sensor", "stuck or absent"),
    "noisy sensor": (Sensor(noise_m_s2=4.0), "sensor", "is the rig at rest? otherwise check cable"),
    "dark camera": (Camera(light=0.02), "camera", "the image is dark"),
    "overexposed camera": (Camera(light=30.0), "camera", "the image is overexposed"),
    "no features": (Camera(texture=False), "camera", "no texture"),
    "out of focus": (Camera(blur_px=12.0), "camera", "focus the lens"),
    "slow camera": (Camera(rate_hz=40.0), "camera", "40.0 frames a second"),
    "frozen camera": (Camera(frozen=True), "camera", "repeats the same image"),
    "wrong counters": (Camera(counter_stands=True), "camera", "counter runs backwards or stands"),
    "no frames": (Camera(frames=0), "camera", "0 frames arrived"),
    "exposure longer than the period": (Camera(exposure_s=0.020), "camera", "longer than the period"),
    "wrong key": (Supervised(key=OTHER_KEY), "link", "the keys differ"),
    "wrong port": (Supervised(another_port=True), "link", "supervisor_port"),
    "no supervisor": (Supervised(runs=False), "link", "start it there"),
    "key that others may read": (KeyFile(mode=0o644), "link", "chmod 600"),
    "a file that is no key": (KeyFile(content=b"short"), "link", "no key"),
    "gateway absent": (Gateway(runs=False), "drive", "no gateway answers"),
    "gateway with another key": (Gateway(key=OTHER_KEY), "drive", "same key"),
    "wrong gateway port": (Gateway(another_port=True), "drive", "drive.gateway_port = 9"),
    "odrive absent": (Odrive(present=False), "drive", "drive.odrive.port"),
    "odrive in an error": (Odrive(error=0x40), "drive", "error 0x40"),
    "joint outside its limits": (Odrive(turns=3.0), "drive", "outside the model's"),
    "no privileges": (Machine(missing=("SCHED_FIFO is not allowed (grant: ...)",)), "machine", "SCHED_FIFO"),
}
HEALTHY = [
    Sensor(),
    Camera(),
    Supervised(),
    KeyFile(),
    Gateway(),
    Odrive(),
    Machine(),
    Sensor(mounted=UPSIDE_DOWN),
]


def looked_at(part, tmp_path: Path) -> list[Verdict]:
    if isinstance(part, KeyFile):
        part.folder = tmp_path
    return part.verdicts()


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_in_one_line_with_what_to_do(mistake: str, tmp_path: Path) -> None:
    part, where, words = MISTAKES[mistake]
    failed = [v for v in looked_at(part, tmp_path) if v.level == Level.FAIL]
    named = [v for v in failed if v.where == where and words in v.text]
    assert named, failed
    assert all("\n" not in v.text and v.where == where for v in failed)
    assert len(failed) <= 2  # no flood of consequences


@pytest.mark.parametrize("part", HEALTHY, ids=lambda part: type(part).__name__)
def test_a_rig_without_a_mistake_passes(part, tmp_path: Path) -> None:
    verdicts = looked_at(part, tmp_path)
    assert verdicts and not [v for v in verdicts if v.level == Level.FAIL]


def test_at_least_fifteen_mistakes_are_seeded() -> None:
    assert len(MISTAKES) >= 15
