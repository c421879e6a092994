"""The forms in which a mechanism is met, beside the one that its declaration writes down.

A cause is a mechanism. A drive that lags may have a lower bandwidth, or a further lag behind its command; a limit is of
velocity or of acceleration; friction takes from the command or acts on the motion; what drifts takes any course. Each
form is one more way to fit the same cause; the evidence for the cause is that of its best form.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.common.causes import Place
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import (
    Cause,
    Context,
    Form,
    Trial,
    Values,
    driven,
    free_of,
    has,
    plain,
)
from stillarm.diagnosis.forms.causes import CAUSES
from stillarm.diagnosis.forms.causes.camera_clock_skew import FROM_AN_ONSET as SKEW_FROM_AN_ONSET
from stillarm.diagnosis.forms.causes.mains_hum import WITH_THIRD as HUM_WITH_THIRD
from stillarm.diagnosis.forms.coasting import CAUSE as COASTING_PLAY
from stillarm.diagnosis.forms.courses import (
    arc_terms,
    arc_values,
    delay_std,
    image_std,
    lens_terms,
    lens_values,
    of_course,
    of_terms,
    path_terms,
    path_values,
    shown,
    swing,
    tilt_terms,
    tilt_values,
)
from stillarm.diagnosis.forms.delay_walk import FORM as DELAY_WALK
from stillarm.diagnosis.forms.overtones import FORM as OVERTONES
from stillarm.diagnosis.forms.queued_images import FORM as QUEUED_IMAGES
from stillarm.diagnosis.forms.sensor_walk import BIAS_WALK, IMAGE_WALK
from stillarm.diagnosis.forms.swelling_hum import FORM as SWELLING_HUM
from stillarm.diagnosis.forms.tilted_sensor import FORM as TILTED_SENSOR
from stillarm.diagnosis.forms.wandering_force import FORM as WANDERING_FORCE
from stillarm.diagnosis.physics.quantities import (
    ACCELEROMETER_BEGIN,
    ARM_BEGIN,
    CAMERA_BEGIN,
    DRIVE_BEGIN,
    LAG_BEND,
    MOST_DOWN,
    MOST_UP,
    SLOWING,
    SPEEDING,
)
from stillarm.diagnosis.physics.world import World

BEGINS: dict[Place, str] = {
    "arm": ARM_BEGIN,
    "drive": DRIVE_BEGIN,
    "accelerometer": ACCELEROMETER_BEGIN,
    "camera": CAMERA_BEGIN,
}
"""By place: the quantity that says from when on what departs from the model acts."""

# an imbalance, a play and a mode are of how the arm is built; a payload has an onset of its own
_NO_ONSET = ("gear_backlash", "payload_change", "rotor_imbalance", "second_bending_mode")
_WHOLLY = (("drive_lag", ""), ("drive_dead_time", ""))  # a key of the model, whose other form has an onset


def _exponential_rate(fit: Fit) -> Values:
    """The mean rate over the recording, Hz/s."""
    hz, duration = fit.value("modes.0.frequency_hz"), fit.world.measured.duration_s
    change = fit.value("modal_temperature_drift.relative_change")
    risen = 1.0 - np.exp(-duration / fit.value("modal_temperature_drift.time_constant_s"))
    return {"frequency_rate_hz_per_s": (hz * change * float(risen) / duration, 0.0)}


_FORM_OF = {
    "modal_temperature_drift": Form(
        replace(CAUSES["modal_temperature_drift"], id="stiffness_drift", parameters_of=_exponential_rate),
        "that levels off",
    ),
}
"""Declared causes that are a form of another mechanism."""


def forms(world: World) -> list[Form]:
    """All forms of all causes that the recording can show, the declared ones first."""
    declared = [_FORM_OF.get(name, Form(one)) for name, one in CAUSES.items()]
    return [one for one in (*declared, *_FURTHER) if one.cause.needs(world)]


def from_an_onset(form: Form) -> Form | None:
    """The same form, acting from an instant on; None for one that has an onset, or cannot have one."""
    begins = BEGINS.get(DECLARED[form.id].place)
    if begins is None or form.begins or form.added or form.id in _NO_ONSET or (form.id, form.name) in _WHOLLY:
        return None
    if any("onset" in name for name in form.cause.settle):
        return None
    words = f"{form.name}, from an onset" if form.name else "from an onset"
    return replace(form, name=words, begins=begins, throughout=form)


def _further(
    identifier: str,
    name: str,
    quantities: Mapping[str, tuple[float, ...]],
    parameters: Callable[[Fit], Values],
    needs: Callable[[World], bool] = driven,
    unit_of: Callable[[Context], float] = lambda context: 1.0,
    more_free: tuple[str, ...] = (),
    settle: Mapping[str, float] = MappingProxyType({}),
) -> Form:
    """A form with sizes to begin from for each of its quantities, tried one by one. unit_of: what the sizes
    are shares of. settle: as in Cause."""

    def trials(context: Context) -> list[Trial]:
        unit = unit_of(context)
        count = max(len(sizes) for sizes in quantities.values())
        return [
            Trial({}, ({q: sizes[i] * unit for q, sizes in quantities.items()},), one_sided=True)
            for i in range(count)
        ]

    cause = Cause(
        id=identifier,
        needs=needs,
        trials=trials,
        free=free_of(*quantities, *more_free),
        parameters_of=parameters,
        settle=settle,
    )
    return Form(cause, name)


def _top_command(context: Context) -> float:
    return context.top_command_rad_s


def _top_acceleration(context: Context) -> float:
    """Of the joint, rad/s^2."""
    return float(np.max(np.abs(context.fit.predicted.motion.joint[:, 2])))


def _top_reading(side: int) -> Callable[[Context], float]:
    """The largest that the accelerometer should show on one side, 1 or -1, m/s^2."""
    return lambda context: max(float(np.max(side * shown(context.fit, "acceleration"))), 1e-3)


def _total_dead_time(fit: Fit) -> Values:
    more, std = plain(fit, x="drive.further_dead_time_s")["x"]
    return {"dead_time_s": (fit.value("drive.dead_time_s") + more, std)}


def _with_lag(quantity: str) -> Callable[[Fit], Values]:
    """The bandwidth of one lag as long as the drive's and this one together."""

    def values(fit: Fit) -> Values:
        lag, std = plain(fit, x=quantity)["x"]
        whole = lag + 1.0 / (2.0 * np.pi * fit.value("drive.bandwidth_hz"))
        return {"bandwidth_hz": (1.0 / (2.0 * np.pi * whole), std / (2.0 * np.pi * whole**2))}

    return values


def _fastest(fit: Fit) -> Values:
    """The largest velocity that the limited drive reached, rad/s."""
    reached = float(np.max(np.abs(fit.predicted.motion.joint[:, 1])))
    return {"max_velocity_rad_s": (reached, 0.0)}


def _loss(fit: Fit) -> Values:
    return plain(fit, velocity_loss_rad_s="drive.friction_rad_s")


def _lag(fit: Fit) -> Values:
    return plain(fit, delay_s="accelerometer.lag_s")


def _one_limit(quantity: str) -> Callable[[Fit], Values]:
    return lambda fit: plain(fit, range_m_s2=quantity)


_LAGS = tuple(
    _further("drive_lag", name, {quantity: (0.001, 0.004, 0.015, 0.05)}, _with_lag(quantity))
    for name, quantity in (
        ("a further lag", "drive.further_lag_s"),
        ("while it speeds up", SPEEDING),
        ("while it slows down", SLOWING),
    )
)
_OF_TOP_ACCELERATION = (0.8, 0.5, 0.3, 0.15, 0.07)  # of the largest: limits that a fit begins from
_OF_TOP_COMMAND = (0.97, 0.9, 0.8, 0.6, 0.4)  # of the largest, as above
_LIMITS = tuple(
    _further("drive_saturation", name, {quantity: sizes}, _fastest, unit_of=unit_of)
    for name, quantity, sizes, unit_of in (
        ("of the acceleration", "drive.most_rad_s2", _OF_TOP_ACCELERATION, _top_acceleration),
        ("of the acceleration one way", "drive.most_up_rad_s2", _OF_TOP_ACCELERATION, _top_acceleration),
        (
            "of the acceleration the other way",
            "drive.most_down_rad_s2",
            _OF_TOP_ACCELERATION,
            _top_acceleration,
        ),
        ("of the velocity one way", "drive.fastest_up_rad_s", _OF_TOP_COMMAND, _top_command),
        ("of the velocity the other way", "drive.fastest_down_rad_s", _OF_TOP_COMMAND, _top_command),
    )
)
_OF_TOP_READING = (0.95, 0.88, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)  # of the largest, as above
_ONE_SIDED = tuple(
    _further(
        "accelerometer_clipping", name, {quantity: _OF_TOP_READING}, _one_limit(quantity),
        needs=has("acceleration"), unit_of=_top_reading(side), settle={quantity: 0.02},
    )
    for name, quantity, side in (("of what is above", MOST_UP, 1), ("of what is below", MOST_DOWN, -1))
)  # fmt: skip
_TWO_EQUAL_LAGS = 0.25  # of the bend: a fit may go from there to one lag, or to a filter that rings
_FURTHER: tuple[Form, ...] = (
    *_LAGS,
    _further("drive_dead_time", "on top", {"drive.further_dead_time_s": (0.001, 0.004, 0.012, 0.03)}, _total_dead_time),
    Form(COASTING_PLAY, "with a link that coasts"),
    *_LIMITS,
    *_ONE_SIDED,
    _further(
        "joint_friction", "on the motion", {"drive.friction_rad_s": (0.005, 0.02, 0.08, 0.2)}, _loss,
        unit_of=_top_command,
    ),
    _further(
        "joint_friction", "on the motion, by direction", {"drive.friction_rad_s": (0.01, 0.05, 0.2)}, _loss,
        unit_of=_top_command, more_free=("drive.friction_one_sided",),
    ),
    _further(
        "joint_friction", "on the motion, sticking",
        {"drive.friction_rad_s": (0.01, 0.05, 0.2), "drive.static_friction_rad_s": (0.015, 0.075, 0.3)}, _loss,
        unit_of=_top_command,
    ),
    _further(
        "accelerometer_lag", "of first order", {"accelerometer.lag_s": (0.0005, 0.002, 0.006, 0.02)}, _lag,
        needs=has("acceleration"),
    ),
    _further(
        "accelerometer_lag", "of second order",
        {"accelerometer.lag_s": (0.001, 0.004, 0.012, 0.03), LAG_BEND: (_TWO_EQUAL_LAGS,) * 4}, _lag,
        needs=has("acceleration"),
    ),
    SWELLING_HUM,
    HUM_WITH_THIRD,
    TILTED_SENSOR,
    SKEW_FROM_AN_ONSET,
    of_course(
        "accelerometer_bias_drift", "along a course", "rate_m_s3", "acceleration", "bias", lambda fit: 1.0, 3.0
    ),
    BIAS_WALK,
    of_course(
        "accelerometer_sensitivity_drift", "along a course", "rate_per_s", "acceleration", "gain", swing, 1.0
    ),
    of_course("tracking_drift", "along a course", "rate_px_per_s", "displacement", "drift", image_std, 1.0),
    of_course(
        "tracking_drift", "that wanders", "rate_px_per_s", "displacement", "walk", image_std, 0.1, walk=True
    ),
    IMAGE_WALK,
    of_terms("tracking_drift", "with the path travelled", has("displacement"), "path", path_values, path_terms),
    OVERTONES,
    WANDERING_FORCE,
    of_course("delay_drift", "along a course", "rate_s_per_s", "arrival", "lateness", delay_std, 3.0),
    DELAY_WALK,
    QUEUED_IMAGES,
    of_terms("camera_tilt_coupling", "along an arc", has("displacement"), "arc", arc_values, arc_terms),
    of_terms("camera_tilt_coupling", "with the joint alone", has("displacement"), "tilt", tilt_values, tilt_terms),
    of_terms("lens_distortion", "about a centre", has("displacement"), "lens", lens_values, lens_terms),
)  # fmt: skip
