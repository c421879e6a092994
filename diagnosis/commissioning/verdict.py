"""Whether what was identified is good enough to damp by, in one line; and the mark that the model file then carries."""

from dataclasses import dataclass
from math import isfinite

import msgspec
import numpy as np

from stillarm.common.files.model import Commissioned, Model
from stillarm.diagnosis.calibration.calibrate import Calibration
from stillarm.diagnosis.calibration.start_values import commanded
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.fitting.departures import stretches

_KNOWN_TO = {  # relative deviations at most
    "arm.modes[0].frequency_hz": 0.005,
    "arm.modes[0].damping_ratio": 0.15,
    "arm.modes[0].participation": 0.05,
    "accelerometer.scale": 0.02,
    "camera.scale_px_per_m": 0.02,
}
_DELAY_KNOWN_TO_PERIODS = 0.05
_LEFT = 1.6  # of a channel's noise at rest, as rms: beyond, something moves that the model does not have
_LEFT_SHARE = 0.03  # of the motion: less than that is not worth a refusal
_MISSED_S = 0.02  # of cycles in a row: no drive's watchdog lets go within less


@dataclass(frozen=True)
class CommissioningVerdict:
    """good: the model may be damped by. text: one line. missed_s: for how long the controller missed its cycles while
    the joint moved, where the model is not good."""

    good: bool
    text: str
    missed_s: float = 0.0


def judge(found: Calibration, measured: Measured) -> CommissioningVerdict:
    """By how well each parameter is known, and by what the free run leaves beside the noise at rest."""
    doubts = [*_vague(found), *_left_over(found, measured)]
    if "camera.scale_px_per_m" not in found.parameters:
        doubts.append("no image shows the arm: damping by camera has nothing to go by")
    if "drive.bandwidth_hz" not in found.parameters:
        doubts.append("the joint has not moved: its sense and the image's scale are unknown")
    model = found.model
    mode = model.arm.modes[0]
    line = (
        f"{mode.frequency_hz:.4g} Hz, damping {100.0 * mode.damping_ratio:.2g} %, "
        f"image {model.camera.scale_px_per_m:+.4g} px/m, accelerometer x {model.accelerometer.scale:+.3g}, "
        f"images {1e3 * model.timing.capture_delay_s:.0f} ms late"
    )
    missed_s = _missed_while_moving(measured) if doubts else 0.0
    if missed_s > 0.0:
        doubts.append(
            f"the controller missed its cycles for {missed_s:.2g} s while the joint moved, and nothing tells what the "
            "drive did then: close other programs, and commission again"
        )
    if doubts:
        said = f"not good enough to damp by ({line}): {'; '.join(doubts)}"
        return CommissioningVerdict(False, said, missed_s)
    return CommissioningVerdict(True, f"good to damp by: {line}")


def _vague(found: Calibration) -> list[str]:
    doubts = []
    for key, most in _KNOWN_TO.items():
        if key not in found.parameters:
            continue
        value, std = found.parameters[key]
        if not (isfinite(value) and isfinite(std)) or std > most * abs(value):
            doubts.append(
                f"{key} = {value:.4g} +- {std:.2g} is too uncertain; let it move more (--max-velocity-rad-s, "
                "--max-angle-rad)"
            )
    if "timing.capture_delay_s" in found.parameters:
        period = 1.0 / found.model.arm.modes[0].frequency_hz
        delay, std = found.parameters["timing.capture_delay_s"]
        if std > max(_DELAY_KNOWN_TO_PERIODS * period, 0.01):
            doubts.append(
                f"timing.capture_delay_s = {delay:.3f} +- {std:.2g}: a longer recording is needed (--strike-s)"
            )
    return doubts


def _left_over(found: Calibration, measured: Measured) -> list[str]:
    """Channels of which the free run leaves more than noise, against the noise before the first move."""
    world = found.fit.world
    moving = np.flatnonzero(commanded(measured))
    quiet_s = (moving[0] if len(moving) else measured.cycles) * measured.cycle_s
    doubts = []
    for name in ("acceleration", "displacement", "deflection"):
        if name not in world.channels:
            continue
        time = measured.frames.received_s if name == "displacement" else world.cycle_times
        values = world.channels[name]
        residual = values - found.fit.predicted.channels[name]
        still, rest = (residual[(time < quiet_s) & np.isfinite(residual)], residual[np.isfinite(residual)])
        if len(still) < 30 or len(rest) < 60:
            continue
        before, all_of_it = float(np.std(still)), float(np.sqrt(np.mean(rest**2)))
        if all_of_it > _LEFT * before and all_of_it > _LEFT_SHARE * float(np.nanstd(values)):
            doubts.append(
                f"the free run leaves {all_of_it / max(before, 1e-12):.1f} times the noise of {name}; "
                "`stillarm diagnose` on the recording names the cause"
            )
    return doubts


def _missed_while_moving(measured: Measured) -> float:
    """For how long rows are missing, some in a row each time, where the joint was told to move, s."""
    missing = np.isnan(measured.acceleration) & np.isnan(measured.position) & np.isnan(measured.velocity)
    moving = commanded(measured)
    least = _MISSED_S / measured.cycle_s
    spans = [(begin, end) for begin, end in stretches(missing) if end - begin >= least]
    return measured.cycle_s * sum(end - begin for begin, end in spans if moving[begin:end].any())


def marked(model: Model, found: Calibration, date: str, recording: str) -> Model:
    """The model with its mark."""
    stds = {key: std for key, (_, std) in found.parameters.items() if isfinite(std)}
    return msgspec.structs.replace(model, commissioned=Commissioned(date, recording, stds))
