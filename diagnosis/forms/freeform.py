"""Structure that no listed cause has: terms of free form, each group a rival of every name.

A force over the arm's state or over time, answered by the first mode and seen by all of the arm's sensors; a reading of
one sensor that bends, wanders or rings by itself. Each group is fitted on top of what is known, with the baseline.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.channels import JOINT_CHANNELS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.courses import imaged, walk_over
from stillarm.diagnosis.physics.linear_modes import answer_of_mode, deflection_of_mode
from stillarm.diagnosis.physics.space import Added, hats
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_PIECES = 7  # of a free course over position, velocity, a reading or time
_MOST = 0.8  # of all that a quantity moves, the part within the knots of a free course over it
_SPEEDS = (0.03, 0.35, 0.7, 1.0)
"""Of the joint's largest speed, both ways: knots of a free course over it. The first is near rest, as friction jumps
there."""
_NEARBY = 1e-4  # of the joint's largest speed, over which that course's slope is taken
_WANDER = 0.1  # of a scale, from knot to knot: as much as a course of the tracking wanders, of the image's variation


@dataclass(frozen=True)
class Group:
    """One kind of free-form structure. words: in a sentence; columns: by channel, from a fit; none: not seen here.
    prior_std: of its amounts, where their columns have a unit of their own. over_time: as in Added."""

    name: str
    words: str
    columns: Callable[[Fit], dict[str, Array]]
    prior_std: float | None = None
    over_time: bool = False

    def added(self, fit: Fit) -> Added | None:
        """Its terms for a fit, each scaled to the channels' noise; None where the recording cannot show it."""
        columns = {name: one for name, one in self.columns(fit).items() if name in fit.world.channels}
        if not columns or not all(np.isfinite(one).all() for one in columns.values()):
            return None
        sizes = [np.sqrt(np.mean(one**2, axis=0)) / fit.sigma[name] for name, one in columns.items()]
        largest = np.max(sizes, axis=0)
        seen = largest > 0.0
        if not seen.any():
            return None
        if self.prior_std is not None:
            unscaled = {name: one[:, seen] for name, one in columns.items()}
            return Added(f"free.{self.name}", unscaled, self.prior_std, self.over_time)
        scaled = {name: one[:, seen] / largest[seen] for name, one in columns.items()}
        return Added(f"free.{self.name}", scaled, 100.0, self.over_time)

    def world(self, fit: Fit) -> World | None:
        """A fit's world with its terms; None where the recording cannot show it."""
        added = self.added(fit)
        return fit.world.changed(added=(*fit.world.added, added)) if added is not None else None


@dataclass(frozen=True)
class Free:
    """A group of free terms, or a law without a name, on top of a fit. merit: nats that it adds, less its price.
    channel: where it shows most; gains: nats in each channel; of_all: tells by itself as much as all that was found."""

    group: Group
    merit: float
    channel: str
    fit: Fit
    gains: Mapping[str, float] = field(default_factory=dict)
    of_all: bool = False


def groups(peaks_hz: Iterable[float]) -> list[Group]:
    """All kinds; peaks_hz: frequencies at which a further resonance or a line is tried."""
    found = [
        Group("position", "a force that depends on the deflection", lambda fit: _force(fit, _over(fit, "q"))),
        Group("even", "a force that is not the same to both sides", lambda fit: _force(fit, _even(fit))),
        Group("velocity", "a force that depends on the arm's velocity", lambda fit: _force(fit, _over(fit, "v"))),
        Group("both", "a force that depends on deflection and velocity", lambda fit: _force(fit, _both(fit))),
        Group("memory", "a force that remembers where the arm has been", lambda fit: _force(fit, _memory(fit))),
        Group("joint", "a force that depends on the joint's place and speed", lambda fit: _force(fit, _of_joint(fit))),
        Group("wander", "a stiffness or damping that changes over time", _changing, over_time=True),
        Group("reading", "an accelerometer whose reading is no straight line", _bent_reading),
        Group("reading_curves", "an accelerometer whose gain changes with what it reads", _curved_reading),
        Group("image", "an image whose displacement is no straight line", _bent_image),
        Group("scale", "an image scale that changes over time", _scale_over_time, over_time=True),
        Group("scale_bends", "an image scale that drifts", _scale_that_bends, over_time=True),
        Group("scale_wanders", "an image scale that wanders", _scale_that_wanders, _WANDER, True),
        Group("turning", "an accelerometer that senses the joint's speed", _turning),
        DRIVE,
    ]  # fmt: skip
    for k, hz in enumerate(peaks_hz):
        words = f"a vibration near {hz:.3g} Hz"
        found.append(Group(f"image_rings_{k}", f"{words} in the image alone", _ringing("displacement", hz)))
        found.append(
            Group(f"sensor_rings_{k}", f"{words} in the acceleration alone", _ringing("acceleration", hz))
        )
    return found


def _state(fit: Fit) -> tuple[Array, Array]:
    """Deflection, m, and rate, m/s, of the first mode over the grid."""
    q = fit.predicted.motion.q[:, 0]
    return q, np.gradient(q, fit.world.measured.cycle_s)


def _unit(values: Array) -> Array:
    top = float(np.max(np.abs(values)))
    return values / top if top > 0.0 else values


def _over(fit: Fit, which: str) -> Array:
    q, v = _state(fit)
    return pieces_over(q if which == "q" else v)


def pieces_over(x: Array) -> Array:
    """A free course over a quantity about zero, (samples, 7): by straight pieces between knots, and straight on beyond
    them. What the largest swing does shows in few blocks, or in a held-out one alone."""
    knots = knots_over(x)
    course = hats(x, knots)
    beyond = np.maximum(np.abs(x) - knots[-1], 0.0) / (knots[1] - knots[0])
    for end, inner, on in ((0, 1, beyond * (x < 0.0)), (-1, -2, beyond * (x > 0.0))):
        course[:, end] += on
        course[:, inner] -= on
    return course


def knots_over(x: Array) -> Array:
    """Evenly about zero, (7,), as far as most swings of a quantity go."""
    by_size = np.sort(np.abs(x))
    gone = np.cumsum(by_size)
    top = by_size[np.searchsorted(gone, _MOST * gone[-1])] or 1.0
    return np.linspace(-top, top, _PIECES)


def _even(fit: Fit) -> Array:
    q, v = (_unit(one) for one in _state(fit))
    return np.stack([q * q, np.abs(q), v * v], axis=1)


def _both(fit: Fit) -> Array:
    q, v = (_unit(one) for one in _state(fit))
    powers = [(3, 0), (2, 1), (1, 2), (0, 3), (5, 0), (4, 1), (2, 3), (0, 5)]
    columns = [q**a * v**b for a, b in powers]
    return np.stack([*columns, np.sign(v), np.sign(v) * np.abs(q)], axis=1)


def _memory(fit: Fit) -> Array:
    """Play operators of several widths: the elements of which any rate-independent hysteresis is made (Prandtl and
    Ishlinskii)."""
    q, _ = _state(fit)
    top = float(np.max(np.abs(q))) or 1.0
    columns = []
    for share in (0.02, 0.06, 0.15, 0.4):
        width, at = share * top, np.empty(len(q))
        last = 0.0
        for k, value in enumerate(q.tolist()):
            last = min(max(last, value - width), value + width)
            at[k] = last
        columns.append(q - at)
    return np.stack(columns, axis=1)


def _of_joint(fit: Fit) -> Array:
    joint = fit.predicted.motion.joint
    theta, omega = _unit(joint[:, 0] - joint[0, 0]), _unit(joint[:, 1])
    q, _ = (_unit(one) for one in _state(fit))
    return np.stack(
        [
            theta,
            theta**2,
            np.sin(joint[:, 0]),
            omega,
            omega * np.abs(omega),
            omega**2,
            omega**2 * q,
            theta * q,
        ],
        axis=1,
    )


def _changing(fit: Fit) -> dict[str, Array]:
    return _force(fit, _over_time(fit))


def _over_time(fit: Fit) -> Array:
    q, v = (_unit(one) for one in _state(fit))
    time = fit.world.cycle_times
    course = hats(time, np.linspace(0.0, fit.world.measured.duration_s, _PIECES))
    return np.concatenate([course * q[:, None], course * v[:, None]], axis=1)


def _driven(fit: Fit) -> dict[str, Array]:
    """A joint whose speed is off by any function of the speed that it should have, and rests where it should rest. Not
    where its own sensors tell what it did."""
    world = fit.world
    if any(name in world.channels for name in JOINT_CHANNELS):
        return {}
    speed, acceleration = fit.predicted.motion.joint[:, 1], fit.predicted.motion.joint[:, 2]
    omega, top = _unit(speed), float(np.max(np.abs(speed))) or 1.0
    knots = np.array([*(-one for one in _SPEEDS[::-1]), 0.0, *_SPEEDS])

    def course(at: Array) -> Array:
        return np.asarray(np.delete(hats(at, knots), len(_SPEEDS), axis=1))  # nothing at rest

    step_s, length_m = world.measured.cycle_s, world.length
    off = course(omega)
    angle = np.cumsum(off, axis=0) * step_s
    slope = (course(omega + _NEARBY) - course(omega - _NEARBY)) / (2.0 * _NEARBY)
    turned = slope * (acceleration / top)[:, None]
    hz, damping = fit.value("modes.0.frequency_hz"), fit.value("modes.0.damping_ratio")
    push = fit.value("modes.0.participation") * length_m
    # differences of the speed, whose sum is right where the acceleration jumps, move the mode
    moved = np.gradient(off, step_s, axis=0)
    q, second = answer_of_mode(-push * moved, hz, max(damping, 1e-4), step_s)
    second = second + push * (moved - turned)
    return _of_tip(fit, q, length_m * angle + q, length_m * turned + second)


def _force(fit: Fit, force: Array) -> dict[str, Array]:
    """What forces on the first mode, (cycles, k), over its stiffness, do to the arm's channels."""
    return answered_by_arm(fit, force * (2.0 * pi * fit.value("modes.0.frequency_hz")) ** 2)


def answered_by_arm(fit: Fit, force: Array) -> dict[str, Array]:
    """What forces on the first mode, (cycles, k) m/s^2, do to the arm's channels, measured or not."""
    hz, damping = fit.value("modes.0.frequency_hz"), fit.value("modes.0.damping_ratio")
    q, second = answer_of_mode(force, hz, max(damping, 1e-4), fit.world.measured.cycle_s)
    return _of_tip(fit, q, q, second)


def _of_tip(fit: Fit, deflection: Array, path: Array, acceleration: Array) -> dict[str, Array]:
    """What the arm's channels show of more deflection, m, of the tip's path, m, and of its acceleration, m/s^2; each
    (cycles, k)."""
    found = {"deflection": deflection}
    if "acceleration" in fit.world.channels:
        found["acceleration"] = fit.value("accelerometer.scale") * acceleration
    if "displacement" in fit.world.channels:
        scene = -fit.value("camera.scale_px_per_m") * path
        found["displacement"] = np.stack([imaged(fit, scene[:, i]) for i in range(scene.shape[1])], axis=1)
    return found


def _bent_reading(fit: Fit) -> dict[str, Array]:
    shown = fit.predicted.channels.get("acceleration")
    if shown is None:
        return {}
    return {"acceleration": pieces_over(shown)}


def _curved_reading(fit: Fit) -> dict[str, Array]:
    """Its square and its cube: two numbers for a gain that changes smoothly, even or odd, up to the largest reading."""
    shown = fit.predicted.channels.get("acceleration")
    if shown is None:
        return {}
    about = shown / (float(np.max(np.abs(shown))) or 1.0)
    return {"acceleration": np.stack([about**2, about**3], axis=1)}


def _bent_image(fit: Fit) -> dict[str, Array]:
    shown = fit.predicted.channels.get("displacement")
    if shown is None:
        return {}
    return {"displacement": pieces_over(shown - np.median(shown))}


def _swing_in_image(fit: Fit) -> Array | None:
    """What the image shows of the tip's path, px; None where there is none. A change of its scale is a share of it."""
    shown = fit.predicted.channels.get("displacement")
    return None if shown is None else shown - fit.value("camera.offset_px")


def _scale_over_time(fit: Fit) -> dict[str, Array]:
    swing = _swing_in_image(fit)
    if swing is None:
        return {}
    frames = fit.world.measured.frames
    course = hats(frames.received_s, np.linspace(0.0, fit.world.measured.duration_s, _PIECES))
    return {"displacement": course * _unit(swing)[:, None]}


def _scale_that_bends(fit: Fit) -> dict[str, Array]:
    """A straight line and a bend: what sets in and grows is near to that, and two numbers foretell more than seven
    where the arm swings now and then."""
    swing = _swing_in_image(fit)
    if swing is None:
        return {}
    at = 2.0 * fit.world.measured.frames.received_s / fit.world.measured.duration_s - 1.0
    course = np.stack([at, 1.5 * at**2 - 0.5], axis=1)  # Legendre's
    return {"displacement": course * swing[:, None]}


def _scale_that_wanders(fit: Fit) -> dict[str, Array]:
    swing = _swing_in_image(fit)
    if swing is None:
        return {}
    return {"displacement": walk_over(fit, "displacement") * swing[:, None]}


def _turning(fit: Fit) -> dict[str, Array]:
    joint = fit.predicted.motion.joint
    omega, theta = _unit(joint[:, 1]), joint[:, 0]
    return {"acceleration": np.stack([omega, omega**2, np.cos(theta)], axis=1)}


def _ringing(channel: str, hz: float) -> Callable[[Fit], dict[str, Array]]:
    """Something that rings in one channel alone: shaken by the joint, by the arm, or by itself."""

    def columns(fit: Fit) -> dict[str, Array]:
        if channel not in fit.world.channels or not 0.2 < hz < 0.4 / fit.world.measured.cycle_s:
            return {}
        motion = fit.predicted.motion
        found = []
        for damping in (0.01, 0.05):
            force = np.stack([motion.joint[:, 2], motion.tip_acceleration], axis=1)
            q = deflection_of_mode(force, hz, damping, fit.world.measured.cycle_s)
            found += [q, np.gradient(q, axis=0)]
        phase = 2.0 * pi * hz * fit.world.cycle_times
        found.append(np.stack([np.sin(phase), np.cos(phase)], axis=1))
        whole = np.concatenate(found, axis=1)
        if channel == "displacement":
            whole = np.stack([imaged(fit, whole[:, i]) for i in range(whole.shape[1])], axis=1)
        return {channel: whole}

    return columns


DRIVE = Group("drive", "a joint whose speed is not in proportion to its command", _driven)
