"""Forms that add terms to one channel: a course over time, as knots or as a random walk, and a lens about a centre."""

from collections.abc import Callable
from dataclasses import dataclass
from math import expm1, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Cause, Form, Trial, Values, has, plain
from stillarm.diagnosis.physics.camera import expose
from stillarm.diagnosis.physics.declared_effects import quantity_of
from stillarm.diagnosis.physics.space import Added, hats
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_COURSE_KNOTS = 16  # of a course over the whole recording: a knot every few seconds
WALK_S = 0.4
"""Between the knots of a course that wanders, s."""
_TILT_PX_PER_RAD, _TILT_STD = 100.0, 10.0  # unit of a turn of the image; up to thousands of px a radian
_STRAYED_STD = 10.0  # of what tracking has strayed by the end, in the image's own variation


def _course(
    channel: str, group: str, scale: Callable[[Fit], Array | float], std: float, walk: bool
) -> Callable[[Fit], tuple[Added, ...]]:
    """A course over time of what is added to a channel, in units of `scale`."""

    def added(fit: Fit) -> tuple[Added, ...]:
        columns = walk_over(fit, channel) if walk else _knots_over(fit, channel, _COURSE_KNOTS)
        unit = scale(fit)
        columns = columns * (unit[:, None] if isinstance(unit, np.ndarray) else unit)
        return (Added(group, {channel: columns}, std, over_time=True),)

    return added


def _knots_over(fit: Fit, channel: str, count: int) -> Array:
    return hats(fit.world.times_of(channel), np.linspace(0.0, fit.world.measured.duration_s, count + 1))


def walk_over(fit: Fit, channel: str) -> Array:
    """A random walk over a channel's samples: each column is a step at one of its knots, (samples, knots)."""
    count = max(int(fit.world.measured.duration_s / WALK_S), _COURSE_KNOTS)
    return np.cumsum(_knots_over(fit, channel, count)[:, ::-1], axis=1)[:, ::-1][:, 1:]


def of_course(
    identifier: str,
    name: str,
    parameter: str,
    channel: str,
    group: str,
    scale: Callable[[Fit], Array | float],
    std: float,
    walk: bool = False,
) -> Form:
    """A cause that takes a course of its own over time (`_course`); its rate is the course's mean one."""

    def parameters(fit: Fit) -> Values:
        rate = rate_of_course(fit, channel, group_of(fit, group), scale(fit))
        return _on_top(fit, identifier, parameter, rate)

    return of_terms(
        identifier, name, has(channel), group, parameters, _course(channel, group, scale, std, walk)
    )


@dataclass(frozen=True)
class Walk:
    """A random walk that a fit leaves in a channel. step: standard deviation of what it strays within the time between
    two knots, in the channel's unit; nats: more than the channel's usual law gives, less what its numbers cost."""

    step: float
    nats: float


def walk_that_lasts(lasts_s: float, std: float, nats: float) -> Walk:
    """The walk of a first-order wander. lasts_s: its correlation time; std: its deviation, in the channel's unit."""
    return Walk(std * sqrt(-2.0 * expm1(-WALK_S / lasts_s)), nats)


def of_walk(
    identifier: str, parameter: str, channel: str, group: str, walk_of: Callable[[Fit], Walk | None]
) -> Form:
    """A cause as a random walk, which is judged as a law: by what `walk_of` says of the fit so far. group: of its
    terms, a name of its own."""

    def added(fit: Fit) -> tuple[Added, ...]:
        walk = walk_of(fit)
        if walk is None:
            return ()
        return (Added(group, {channel: walk_over(fit, channel)}, walk.step, over_time=True, walks=True),)

    def nats(last: Fit) -> float:
        walk = walk_of(last)
        return 0.0 if walk is None else walk.nats

    def parameters(fit: Fit) -> Values:
        return _on_top(fit, identifier, parameter, rate_of_course(fit, channel, group_of(fit, group)))

    return of_terms(identifier, "as a random walk", has(channel), group, parameters, added, nats_of=nats)


def rate_of_course(fit: Fit, channel: str, group: Added, unit: Array | float = 1.0) -> float:
    """The mean rate of a fitted course: of the straight line next to it, in the channel's unit a second. unit: what the
    course is a share of, (samples,), if it varies: the rate is that share's then, 1/s."""
    course = group.columns[channel] @ np.array([fit.value(each) for each in group.amounts])
    share_of = unit if isinstance(unit, np.ndarray) else np.ones(len(course))
    line = np.stack([share_of, share_of * fit.world.times_of(channel)], axis=1)
    return float(np.linalg.lstsq(line, course, rcond=None)[0][1])


def _on_top(fit: Fit, cause: str, parameter: str, rate: float) -> Values:
    """A course's rate as its cause's parameter: it comes on top of the one that the model declares already."""
    name = quantity_of(cause, parameter)
    declared = fit.value(name) if name in fit.world.space.place else 0.0
    return {parameter: (rate + declared, 0.0)}


def of_terms(
    identifier: str,
    name: str,
    needs: Callable[[World], bool],
    group: str,
    parameters: Callable[[Fit], Values],
    added: Callable[[Fit], tuple[Added, ...]],
    nats_of: Callable[[Fit], float] | None = None,
) -> Form:
    """A form of a group of added terms. needs: as in Cause; nats_of: as in Form."""

    def amounts(world: World) -> tuple[str, ...]:
        one = world.added_group(group)
        return () if one is None else one.amounts

    cause = Cause(
        id=identifier,
        needs=needs,
        trials=lambda context: [Trial({}, ({},))],
        free=amounts,
        parameters_of=parameters,
    )
    return Form(cause, name, added, nats_of=nats_of)


def group_of(fit: Fit, name: str) -> Added:
    """The added terms of a form, in a fit of it."""
    one = fit.world.added_group(name)
    assert one is not None
    return one


def shown(fit: Fit, channel: str) -> Array:
    """What a channel should show; zeros where it was not measured, of which no form is made."""
    one = fit.channel(channel)
    return one.predicted if one is not None else np.zeros(1)


def swing(fit: Fit) -> Array:
    """What the accelerometer shows of the arm, less its bias."""
    return np.asarray(shown(fit, "acceleration") - fit.value("accelerometer.bias_m_s2"))


def image_std(fit: Fit) -> float:
    seen = fit.world.channels.get("displacement")
    return float(np.nanstd(seen)) if seen is not None else 1.0


def delay_std(fit: Fit) -> float:
    return fit.world.model.timing.capture_delay_std_s or 0.005


def lens_terms(fit: Fit) -> tuple[Added, ...]:
    seen = shown(fit, "displacement")
    size = float(np.max(np.abs(seen))) or 1.0
    about = seen / size
    return (Added("lens", {"displacement": np.stack([about**2, about**3], axis=1) * size}, 0.3),)


def lens_values(fit: Fit) -> Values:
    one = group_of(fit, "lens")
    size = float(np.max(np.abs(shown(fit, "displacement")))) or 1.0
    cubic, std = plain(fit, x=one.amounts[1])["x"]
    return {"coefficient_per_px2": (cubic / size**2, std / size**2)}


def tilt_terms(fit: Fit) -> tuple[Added, ...]:
    """An image that moves with the joint's angle, whatever the arm's bend: a camera that the joint carries."""
    joint = fit.predicted.motion.joint[:, 0]
    column = imaged(fit, -_TILT_PX_PER_RAD * joint)[:, None]
    return (Added("tilt", {"displacement": column}, _TILT_STD),)


def tilt_values(fit: Fit) -> Values:
    return _turned(fit, "tilt")


def _turned(fit: Fit, group: str) -> Values:
    amount, std = plain(fit, x=group_of(fit, group).amounts[0])["x"]
    known = fit.value("camera.rotation_px_per_rad")
    return {"rotation_px_per_rad": (known + _TILT_PX_PER_RAD * amount, _TILT_PX_PER_RAD * std)}


def arc_terms(fit: Fit) -> tuple[Added, ...]:
    """The same where the tip turns far: with the angle's sine or tangent, whose next term is its third power."""
    angle = fit.predicted.motion.tip_angle
    far = float(np.max(np.abs(angle))) or 1.0
    powers = (angle, angle**3 / far**2)
    columns = np.stack([imaged(fit, -_TILT_PX_PER_RAD * one) for one in powers], axis=1)
    return (Added("arc", {"displacement": columns}, _TILT_STD),)


def arc_values(fit: Fit) -> Values:
    """The rotation while the angle is small."""
    return _turned(fit, "arc")


def path_terms(fit: Fit) -> tuple[Added, ...]:
    """Tracking that strays by a share of the path that the tip has travelled in the image."""
    tip = fit.predicted.motion.tip
    path = np.cumsum(np.abs(np.diff(tip, prepend=tip[:1])))
    column = imaged(fit, path / (float(path[-1]) or 1.0))[:, None] * image_std(fit)
    return (Added("path", {"displacement": column}, _STRAYED_STD),)


def path_values(fit: Fit) -> Values:
    """The mean rate over the recording."""
    amount, std = plain(fit, x=group_of(fit, "path").amounts[0])["x"]
    unit = image_std(fit) / fit.world.measured.duration_s
    rate, _ = _on_top(fit, "tracking_drift", "rate_px_per_s", unit * amount)["rate_px_per_s"]
    return {"rate_px_per_s": (rate, unit * std)}


def imaged(fit: Fit, scene: Array) -> Array:
    """What the camera would make of a motion over the grid, px."""
    instants = fit.world.instants(fit.vector)
    value, rate = np.empty(len(instants)), np.empty(len(instants))
    exposure, step = fit.world.model.camera.exposure_s, fit.world.measured.cycle_s
    expose(np.ascontiguousarray(scene), instants, exposure, step, value, rate)
    return value
