"""The model's parameters from a recording, with uncertainties: modes, drive, signs and scales, delay, noise levels.

The same simulation and the same likelihood as the diagnosis, with more set free, and started where the data point
(stillarm.diagnosis.calibration.start_values), whatever the model says; where the joint has not moved, or what it did
explains too little,
from a grid of frequencies and capture delays, signs and scales being linear.
"""

from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.calibration.delay_spread import DelaySpread, delay_spread
from stillarm.diagnosis.calibration.start_values import start_values
from stillarm.diagnosis.data.channels import ARM_CHANNELS, without_dead_sensors
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import fit_with_impacts, refit_with
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Data, Fit, make_data, refitted_model
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.physics.quantities import QUARTZ, SKEW
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
_DELAYS_S = (0.02, 0.05, 0.08, 0.11, 0.14, 0.17)
_PEAKS = 4
_SHORTEST_S = 3.0
_SCALES = ("modes.0.participation", "accelerometer.scale", "camera.scale_px_per_m")
_FOLLOWED = 0.7  # of a channel's variation left: impacts that nobody has told of may be there, too


@dataclass(frozen=True)
class Calibration:
    """The model found, and its parameters with standard deviations: model key -> (value, std)."""

    model: Model
    parameters: dict[str, tuple[float, float]]
    nrmse: dict[str, float]
    fit: Fit


def calibrate(
    measured: Measured, model: Model, tick: Callable[[float, str], None] = lambda done, what: None
) -> Calibration:
    """Find the parameters. Raises UserError for a recording that shows too little of the arm."""
    if measured.pair:
        raise UserError(
            f"{measured.name}: holds a pair of input and output, which no model file describes; `stillarm diagnose` "
            "fits it, or import the columns as a bundle with a fast.csv"
        )
    if measured.duration_s < _SHORTEST_S:
        raise UserError(
            f"{measured.name}: {measured.duration_s:.1f} s are too short to calibrate by; record 20 s or more"
        )
    measured, dead = without_dead_sensors(measured)
    world = World(measured, model)
    if not set(ARM_CHANNELS) & set(world.channels):
        why = "; ".join(f"{name}: {reason}" for name, reason in (dead | world.channels_left_out).items())
        raise UserError(
            f"{measured.name}: no channel shows the arm (acceleration, displacement or deflection)"
            f"{f' ({why})' if why else ''}; record one of them while the arm moves"
        )
    split = Split(np.array([0.0, measured.duration_s]), np.zeros(1, dtype=bool))
    tick(0.05, "frequency, signs, delay")
    begun = _begun(measured, model, split, tick)
    tick(0.5, "all parameters")
    last = fit_with_impacts(World(measured, begun), split)
    tick(0.75, "drive, camera's clock")
    last = refit_with(last, split, last.world.impacts, _more(last.world))
    tick(0.95, "noise")
    return Calibration(_model(model, last), _parameters(last), _errors(last), last)


def _begun(measured: Measured, model: Model, split: Split, tick: Callable[[float, str], None]) -> Model:
    """A model from which a fit in small steps gets there."""
    start = start_values(measured, model)
    if start is not None:
        model = start.model
        if start.moved and _explains(World(measured, model), split):
            return model
    tick(0.1, "frequencies and delays")
    best = _first(make_data(World(measured, model), split))
    modes = [
        msgspec.structs.replace(model.arm.modes[0], frequency_hz=best.value("modes.0.frequency_hz")),
        *model.arm.modes[1:],
    ]
    return msgspec.structs.replace(
        model,
        arm=msgspec.structs.replace(model.arm, modes=modes),
        accelerometer=msgspec.structs.replace(model.accelerometer, scale=best.value("accelerometer.scale")),
        camera=msgspec.structs.replace(model.camera, scale_px_per_m=best.value("camera.scale_px_per_m")),
        timing=msgspec.structs.replace(
            model.timing, capture_delay_s=max(0.0, best.value("timing.capture_delay_s"))
        ),
    )


def _explains(world: World, split: Split) -> bool:
    """Whether the free run from this start follows the motion that the moves have made."""
    last = fit(make_data(world, split), world.space.vector(), _constants(world), iterations=2)
    shown = [error for name, error in _errors(last).items() if name in ARM_CHANNELS]
    return bool(shown) and min(shown) < _FOLLOWED


def _constants(world: World) -> tuple[str, ...]:
    """What no start value tells: where each channel's zero lies, and the arm's state at the beginning."""
    return tuple(name for name in _linear(world) if name not in _SCALES)


def _more(world: World) -> tuple[str, ...]:
    """What calibration frees beyond the diagnosis' baseline."""
    names: list[str] = []
    moved = bool(np.any(np.abs(np.nan_to_num(world.measured.command)) > 0.0))
    if moved and not world.measured.imposed:
        names += ["drive.bandwidth_hz", "drive.dead_time_s"]
    if "acceleration" in world.channels and ({"displacement", "deflection"} & set(world.channels) or moved):
        names.append("accelerometer.scale")
    if "arrival" in world.channels and world.frame_clock.counted:
        names.append(SKEW)
    return tuple(names)


def _first(data: Data) -> Fit:
    """The best of many starts: frequency at each large peak of the spectrum, delays over a grid."""
    world = data.world
    plain = fit(data, world.space.vector(), (), iterations=0)
    named = world.model.arm.modes[0].frequency_hz
    found = [f for peaks in residual_peaks(plain).values() for f in peaks[:_PEAKS] if 0.3 < f < 40.0]
    frequencies = list(dict.fromkeys([named, *found]))
    linear = _linear(world)
    best: Fit | None = None
    place = world.space.place
    delays = _DELAYS_S if "displacement" in world.channels else (world.model.timing.capture_delay_s,)
    for frequency in frequencies:
        for delay in delays:
            start = world.space.vector()
            start[place["modes.0.frequency_hz"]] = frequency
            start[place["timing.capture_delay_s"]] = delay
            one = fit(data, start, linear, iterations=2, prior=start)
            if best is None or one.train_log_likelihood > best.train_log_likelihood:
                best = one
    assert best is not None
    free = (*linear, "modes.0.frequency_hz", "modes.0.damping_ratio")
    free = (*free, "timing.capture_delay_s") if "displacement" in world.channels else free
    return fit(data, best.vector, free, iterations=12, prior=best.vector)


def _linear(world: World) -> tuple[str, ...]:
    """Quantities on which the channels depend linearly, so that any start will do."""
    names = ["jump.0.0.q", "jump.0.0.v", "modes.0.participation"]
    has = world.channels
    if "joint_position" in has:
        names.append("start.theta")
    if "joint_position" in has or "joint_velocity" in has:
        names.append("start.omega")
    if "acceleration" in has:
        names += ["accelerometer.bias_m_s2", "accelerometer.scale"]
    if "displacement" in has:
        names += ["camera.scale_px_per_m", "camera.offset_px"]
    if "arrival" in has:
        names.append("timing.arrival_s")
    return tuple(names)


def _model(model: Model, last: Fit) -> Model:
    found = refitted_model(model, last)
    drive, sensor = found.drive, found.accelerometer
    if "drive.bandwidth_hz" in last.free:
        drive = msgspec.structs.replace(
            drive,
            bandwidth_hz=last.value("drive.bandwidth_hz"),
            dead_time_s=last.value("drive.dead_time_s"),
        )
    if "accelerometer.scale" in last.free:
        sensor = msgspec.structs.replace(sensor, scale=last.value("accelerometer.scale"))
    timing, camera = found.timing, found.camera
    if (spread := _delay_spread(last)) is not None:
        timing = msgspec.structs.replace(timing, capture_delay_std_s=spread.std_s)
    if SKEW in last.free:
        rate, _ = _frame_rate(last)
        camera = msgspec.structs.replace(
            camera, frame_rate_hz=rate, exposure_s=min(camera.exposure_s, 1.0 / rate)
        )
    return msgspec.structs.replace(found, drive=drive, accelerometer=sensor, timing=timing, camera=camera)


def _delay_spread(last: Fit) -> DelaySpread | None:
    """Spread of the capture delay: of the arrivals about the camera's clock, where it has one."""
    world = last.world
    arrivals = last.channel("arrival")
    if arrivals is None:
        return None
    return delay_spread(arrivals.off, 1.0 / world.model.camera.frame_rate_hz, world.measured.duration_s)


def _frame_rate(last: Fit) -> tuple[float, float]:
    """The camera's frame rate on the controller's clock, Hz, and its deviation."""
    counted = last.world.model.camera.frame_rate_hz
    rate = counted / (1.0 + 1e-6 * (last.value(SKEW) + last.value(QUARTZ)))
    return rate, 1e-6 * last.std[SKEW] * rate


_KEYS = {
    "accelerometer.scale": "accelerometer.scale",
    "accelerometer.bias_m_s2": "accelerometer.bias_m_s2",
    "camera.scale_px_per_m": "camera.scale_px_per_m",
    "timing.capture_delay_s": "timing.capture_delay_s",
    "drive.bandwidth_hz": "drive.bandwidth_hz",
    "drive.dead_time_s": "drive.dead_time_s",
}


def _parameters(last: Fit) -> dict[str, tuple[float, float]]:
    found: dict[str, tuple[float, float]] = {}
    for i in range(len(last.world.model.arm.modes)):
        for name in ("frequency_hz", "damping_ratio", "participation"):
            found[f"arm.modes[{i}].{name}"] = (last.value(f"modes.{i}.{name}"), last.std[f"modes.{i}.{name}"])
    for name, key in _KEYS.items():
        if name in last.free:
            found[key] = (last.value(name), last.std[name])
    if SKEW in last.free:
        found["camera.frame_rate_hz"] = _frame_rate(last)
    if (spread := _delay_spread(last)) is not None:
        if "timing.capture_delay_s" in found:  # arrivals without an image tell the spread only
            delay, std = found["timing.capture_delay_s"]
            found["timing.capture_delay_s"] = delay, max(std, spread.mean_std_s)
        found["timing.capture_delay_std_s"] = spread.std_s, spread.std_of_std_s
    for channel, key in (
        ("acceleration", "accelerometer.noise_std_m_s2"),
        ("displacement", "camera.noise_std_px"),
    ):
        one = last.channel(channel)
        if one is not None:
            count = int(np.isfinite(one.measured).sum())
            found[key] = (one.sigma, one.sigma / (2.0 * max(count, 1)) ** 0.5)
    return found


def _errors(last: Fit) -> dict[str, float]:
    """Free-run error of each channel as a part of its variation."""
    found = {}
    for name, values in last.world.channels.items():
        residual = values - last.predicted.channels[name]
        spread = float(np.nanstd(values - (last.world.frame_clock.grid_s if name == "arrival" else 0.0)))
        found[name] = float(np.sqrt(np.nanmean(residual**2))) / (spread or 1.0)
    return found
