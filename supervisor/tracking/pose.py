"""Poses of the scene in the image, and the sum of a key frame's pose and the motion since that key frame.

Between a key frame and the present a scene point p (relative to the image's centre) moves to R(rotation) p + d. The
total displacement is the sum of d key frame by key frame, each in the axes half-way between key frame and present:

    total = key + R(-rotation / 2) d,     total rotation = key rotation + rotation

A camera that an arm carries along an arc turns with the arm; in its own axes it always moves sideways. The sum of the
motion in its own axes is the length of the arc (to rotation^2 / 24), which is the definition of displacement_px.
Rotating the earlier displacement instead, as a rigid transformation would, multiplies every error of the rotation by
hundreds of px. With half-way axes a motion and its reverse cancel exactly.
"""

from math import cos, sin
from typing import NamedTuple


class Pose(NamedTuple):
    """Displacement x, y in px and rotation in rad of the scene, since the first frame or since a key frame."""

    x: float
    y: float
    rotation: float


def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """The vector (x, y) turned by `angle` rad from x towards y."""
    c, s = cos(angle), sin(angle)
    return c * x - s * y, s * x + c * y


def total_pose(key: Pose, since_key: Pose) -> Pose:
    """Pose since the first frame, from the key frame's and the rigid motion since the key frame."""
    x, y = turned(since_key.x, since_key.y, -0.5 * since_key.rotation)
    return Pose(key.x + x, key.y + y, key.rotation + since_key.rotation)


def pose_since(key: Pose, total: Pose) -> Pose:
    """The inverse of total_pose(): rigid motion since the key frame."""
    rotation = total.rotation - key.rotation
    x, y = turned(total.x - key.x, total.y - key.y, 0.5 * rotation)
    return Pose(x, y, rotation)


def extrapolated(before: Pose, last: Pose, frames: int) -> Pose:
    """Pose at constant velocity `frames` frames after `last`. `before` is one frame earlier than `last`."""
    return Pose(*(b + frames * (b - a) for a, b in zip(before, last, strict=True)))
