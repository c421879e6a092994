"""Checks bus and accelerometer: speed, identity, rate, noise, gravity; all from readings of a rig at rest."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, hypot
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import Accelerometer, SampleStatus
from stillarm.drivers.accelerometers.mounting import measured_direction, sensed_axes
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_SLOWEST_BUS_HZ = 300_000
_READ_BITS = 93  # of a transfer of 7 bytes: 10 bytes of 9 bits, two starts, a stop
_WRONG_SIZE = 0.08  # of gravity: zero-g offset plus scale error of the worst of the supported parts
_TILT_M_S2 = 1.7  # 10 degrees
_MOST_MISSING = 0.02  # of the reads: more is a fault
_STUCK_READS = 50  # fewest samples of a working sensor in the time of the check
_QUIETEST = 0.02  # of the model's noise
_LOUDEST, _LOUD = 4.0, 2.0  # times the model's noise: fails, warns

Values = NDArray[np.float64]


@dataclass(frozen=True)
class SensorFacts:
    """What was observed of the accelerometer.

    identity: as the device states it. acceleration_m_s2: fresh samples along the sensor's axes, shape (n, 3). span_s:
    duration. missing: reads without a sample; longest_missing: of these, so many in a row at most. rate_hz: the
    device's setting. fastest_read_s: time of a bus transfer.
    """

    identity: str
    acceleration_m_s2: Values
    span_s: float
    reads: int
    missing: int
    longest_missing: int
    rate_hz: float
    fastest_read_s: float


def declared_bus_hz(bus: str) -> float | None:
    """Clock of /dev/i2c-N in the device tree, Hz; None if it does not say."""
    path = Path("/sys/class/i2c-adapter") / Path(bus).name / "of_node" / "clock-frequency"
    try:
        return float(int.from_bytes(path.read_bytes()[:4], "big"))
    except OSError:
        return None


def judge_bus(bus: str, declared_hz: float | None, fastest_read_s: float, cycle_s: float) -> Verdict:
    """The bus's speed: from the device tree, or else from the fastest transfer."""
    if declared_hz is not None:
        hz, how = declared_hz, "from the device tree"
    else:
        hz, how = (
            _READ_BITS / max(fastest_read_s, 1e-9),
            f"since a read of 7 bytes took {1e6 * fastest_read_s:.0f} us",
        )
    share = fastest_read_s / cycle_s
    if hz < _SLOWEST_BUS_HZ:
        return fail(
            "bus",
            f"accelerometer.bus = {bus!r}: {hz / 1e3:.0f} kHz ({how}): a read takes {100.0 * share:.0f} % of a "
            "cycle; set it to 400 kHz (Raspberry Pi: dtparam=i2c_arm_baudrate=400000 in config.txt; else "
            "clock-frequency in the device tree)",
        )
    if share > 0.5:
        return warn("bus", f"{bus}: a read takes {100.0 * share:.0f} % of a cycle; use a faster bus")
    return ok("bus", f"{bus}: a read takes {1e6 * fastest_read_s:.0f} us, {100.0 * share:.0f} % of a cycle")


def read_sensor(
    accelerometer: Accelerometer,
    cycle_s: float,
    span_s: float,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> SensorFacts:
    """Read a started accelerometer once a cycle for a while."""
    samples: list[tuple[float, float, float]] = []
    reads = missing = in_a_row = longest = 0
    fastest = float("inf")
    begun = clock()
    while (now := clock()) < begun + span_s:
        accelerometer.read()
        fastest = min(fastest, clock() - now)
        reads += 1
        reading = accelerometer.last_reading()
        if reading.status == SampleStatus.FRESH:
            samples.append(reading.acceleration_xyz_m_s2)
        lacks = reading.status not in (SampleStatus.FRESH, SampleStatus.HELD)
        missing += lacks
        in_a_row = in_a_row + 1 if lacks else 0
        longest = max(longest, in_a_row)
        sleep(max(0.0, begun + reads * cycle_s - clock()))
    span_s = clock() - begun
    try:
        identity = accelerometer.identify()
    except OSError:  # gone in the meantime; the missing samples show it
        identity = ""
    return SensorFacts(
        identity,
        np.array(samples, dtype=np.float64).reshape(-1, 3),
        span_s,
        reads,
        missing,
        longest,
        accelerometer.rate_hz,
        fastest,
    )


def judge_sensor(facts: SensorFacts, device: AccelerometerDevice, model: Model) -> list[Verdict]:
    """Identity, rate, noise, gravity."""
    verdicts = [ok("sensor", f"{facts.identity or device.driver}")]
    if len(facts.acceleration_m_s2) < _STUCK_READS:
        verdicts.append(
            fail(
                "sensor",
                f"{len(facts.acceleration_m_s2)} samples in {facts.reads} reads ({facts.missing} missing): the "
                "accelerometer is stuck or absent; switch its power off and on, check wiring and supply voltage",
            )
        )
        return verdicts
    verdicts.append(_judge_rate(facts, model.timing.cycle_s))
    direction = np.array(measured_direction(device))
    along = facts.acceleration_m_s2 @ direction
    stuck = _judge_noise(facts.acceleration_m_s2, along, model)
    return [*verdicts, stuck, *_judge_gravity(facts, device, direction)]


def judge_pause(facts: SensorFacts) -> Verdict | None:
    """A warning where too many reads gave no sample, most of them in one row: a look to be repeated. Else None."""
    if facts.missing <= _MOST_MISSING * facts.reads or 2 * facts.longest_missing < facts.missing:
        return None
    return warn(
        "sensor",
        f"{facts.longest_missing} reads in a row gave no sample, as when a computer is paused or a plug is loose; "
        "looked again",
    )


def _judge_rate(facts: SensorFacts, cycle_s: float) -> Verdict:
    reached = len(facts.acceleration_m_s2) / facts.span_s
    asked = facts.reads / facts.span_s
    possible = min(facts.rate_hz, asked)
    text = f"{reached:.0f} fresh samples in {asked:.0f} reads a second (set to {facts.rate_hz:g})"
    if facts.missing > _MOST_MISSING * facts.reads:
        return fail(
            "sensor",
            f"{facts.missing} of {facts.reads} reads gave no sample; check wiring, pull-ups and cable length",
        )
    if reached < 0.5 * possible:
        return fail(
            "sensor",
            f"{text}: it does not keep its rate; choose another accelerometer.bandwidth_hz, or another part",
        )
    if facts.rate_hz < 0.99 / cycle_s:
        return warn(
            "sensor", f"{text}: slower than the cycle; each sample is used for {1e3 / facts.rate_hz:.1f} ms"
        )
    return ok("sensor", text)


def _judge_noise(acceleration: Values, along: Values, model: Model) -> Verdict:
    noise = float(np.std(along))
    expected = abs(model.accelerometer.scale) * model.accelerometer.noise_std_m_s2
    text = f"noise {noise:.3g} m/s^2 at rest (the model says {expected:.3g})"
    if noise == 0.0 and not np.any(np.std(acceleration, axis=0) > 0.0):
        return fail(
            "sensor",
            "the same reading every time: the accelerometer is stuck; switch its power off and on, or replace it",
        )
    if noise > _LOUDEST * max(expected, 0.05):
        return fail(
            "sensor",
            f"{text}: is the rig at rest? otherwise check cable, supply and mounting, or enter it as the model's "
            "accelerometer.noise_std_m_s2",
        )
    if noise > _LOUD * max(expected, 0.05) or noise < _QUIETEST * expected:
        return warn("sensor", f"{text}: enter the measured value as the model's accelerometer.noise_std_m_s2")
    return ok("sensor", text)


def _judge_gravity(facts: SensorFacts, device: AccelerometerDevice, direction: Values) -> list[Verdict]:
    """Expected: a magnitude of 1 g, none of it along the measured axis, pointing up according to the mounting."""
    mean = np.mean(facts.acceleration_m_s2, axis=0)
    size = float(np.linalg.norm(mean))
    words = "(" + ", ".join(f"{value:+.1f}" for value in mean) + ") m/s^2 along the sensor's x, y, z"
    if abs(size / STANDARD_GRAVITY_M_S2 - 1.0) > _WRONG_SIZE:
        return [
            fail(
                "sensor",
                f"gravity is {size:.2f} m/s^2, {words}, instead of 9.81: accelerometer.driver or full_scale_g does "
                "not match the device, or the device is damaged",
            )
        ]
    along = float(mean @ direction) - device.bias_m_s2
    if abs(along) > _TILT_M_S2:
        tilt = degrees(np.arcsin(min(1.0, abs(along) / STANDARD_GRAVITY_M_S2)))
        return [
            fail(
                "sensor",
                f"accelerometer.axis = {device.axis!r} carries {along:+.1f} m/s^2 of gravity ({tilt:.0f} degrees off "
                f"the horizontal; {words}): name the axis along which the arm vibrates, or the mounting in "
                "rotation_deg; for an arm that vibrates up and down enter it as accelerometer.bias_m_s2",
            )
        ]
    up = np.array(sensed_axes(0.0, device))
    if abs(device.bias_m_s2) <= _TILT_M_S2:
        upwards = float(mean @ up) / STANDARD_GRAVITY_M_S2
        if upwards < -0.8 * size:
            return [
                fail(
                    "sensor",
                    f"gravity has the wrong sign ({words}): the sensor hangs upside down; turn it, or set "
                    "accelerometer.rotation_deg (180 about one axis), and check accelerometer.sign",
                )
            ]
        if upwards < 0.8 * size:
            return [
                warn(
                    "sensor",
                    f"gravity lies on another axis than the mounting implies ({words}); correct rotation_deg",
                )
            ]
    return [ok("sensor", f"gravity {size:.2f} m/s^2, {hypot(along):.2f} of it along the measured axis")]


def could_not_start(error: UserError) -> Verdict:
    """The verdict on a sensor that cannot be opened; the error says why."""
    return fail("sensor", str(error))
