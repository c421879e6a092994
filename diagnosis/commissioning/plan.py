"""What the joint does while a rig is commissioned: two scenarios, the second planned by what the first has shown.

Probe: the joint stands; then it is nudged to and fro, each stage twice as fast as the one before. How far to go, the
watch decides (stillarm.diagnosis.commissioning.watch). Moves: at the greatest velocity found safe, nudges of
about half a
period, which excite most and turn back, slow moves between two poses for the image's scale, and the joint stands while
the arm rings.
"""

from dataclasses import dataclass

import msgspec

from stillarm.common.files.model import Drive, Mode
from stillarm.common.files.scenario import Move, Scenario
from stillarm.common.user_error import UserError

QUIET_S = 3.0
_FIRST_RAD_S = 0.004
_PROBE_RAMP_S, _PROBE_S, _PROBE_EVERY_S = 0.02, 0.1, 1.3
_STAGE_PAIRS = 2
_LONGEST_RING_S, _SHORTEST_RING_S = 30.0, 8.0
_RUNG_DOWN = 3.0  # decay times
_BETWEEN_PERIODS = 2.3


@dataclass(frozen=True)
class Limits:
    """What no move exceeds. Angle: from where the joint stands at the start. image_px: of the image's displacement.

    range_share: of the accelerometer's range.
    """

    angle_rad: float = 0.06
    velocity_rad_s: float = 0.15
    acceleration_rad_s2: float = 8.0
    image_px: float = 120.0
    range_share: float = 0.6


@dataclass(frozen=True)
class Stage:
    """Part of the probe in which the joint moves at one velocity, rad/s; the arm may ring on until the end."""

    start_s: float
    end_s: float
    velocity_rad_s: float


def within(limits: Limits, drive: Drive) -> Limits:
    """The limits, no wider than the drive's own. Raises UserError where no room is left."""
    lowest = min(drive.max_velocity_rad_s, limits.velocity_rad_s)
    acceleration = min(drive.max_acceleration_rad_s2, limits.acceleration_rad_s2)
    room = min(limits.angle_rad, 0.5 * (drive.max_position_rad - drive.min_position_rad))
    if lowest < _FIRST_RAD_S or room < _FIRST_RAD_S * _PROBE_S:
        raise UserError(
            f"commission: {lowest:g} rad/s and {room:g} rad leave no room for a move; at least {_FIRST_RAD_S:g} rad/s "
            f"(--max-velocity-rad-s, drive.max_velocity_rad_s) and {_FIRST_RAD_S * _PROBE_S:g} rad "
            "(--max-angle-rad) are needed"
        )
    return Limits(room, lowest, acceleration, limits.image_px, limits.range_share)


def stages(limits: Limits) -> list[Stage]:
    """The probe's stages, each at twice the velocity of the one before, up to the limits."""
    found: list[Stage] = []
    velocity, start = _FIRST_RAD_S, QUIET_S
    most = min(
        limits.velocity_rad_s,
        limits.acceleration_rad_s2 * _PROBE_RAMP_S,
        limits.angle_rad / (_PROBE_S - _PROBE_RAMP_S),
    )
    while velocity <= most * (1.0 + 1e-9):
        end = start + 2 * _STAGE_PAIRS * _PROBE_EVERY_S
        found.append(Stage(start, end, velocity))
        start, velocity = end, 2.0 * velocity if velocity >= most or 2.0 * velocity <= most else most
    return found


def probe(limits: Limits) -> Scenario:
    """Quiet, then the stages. Each nudge goes back where it came from."""
    plan = stages(limits)
    moves = []
    for stage in plan:
        for i in range(2 * _STAGE_PAIRS):
            begin = stage.start_s + i * _PROBE_EVERY_S
            velocity = stage.velocity_rad_s if i % 2 == 0 else -stage.velocity_rad_s
            moves.append(Move(begin, begin + _PROBE_S, velocity, _PROBE_RAMP_S))
    return Scenario(duration_s=plan[-1].end_s + 0.5, moves=moves)


def moves(limits: Limits, velocity_rad_s: float, mode: Mode, strike_s: float = 0.0) -> Scenario:
    """The main part, half a minute to a minute, none of it faster than `velocity_rad_s`.

    mode: the first one, roughly. Quick pairs, slow moves, a pair without a pause that excites most, and rest; then
    `strike_s` more, for a strike by hand.
    """
    frequency = mode.frequency_hz
    half = 0.5 / frequency
    longest_ramp = 0.45 * half
    velocity = min(velocity_rad_s, limits.angle_rad / half, limits.acceleration_rad_s2 * longest_ramp)
    ramp = min(max(velocity / limits.acceleration_rad_s2, _PROBE_RAMP_S, 0.3 * half), longest_ramp)
    decay_s = 1.0 / max(mode.damping_ratio * mode.angular_frequency, 1e-3)
    ring = min(max(_RUNG_DOWN * decay_s, _SHORTEST_RING_S), _LONGEST_RING_S)
    between = max(_BETWEEN_PERIODS / frequency, 0.6)
    found: list[Move] = []
    now = QUIET_S
    for share, sign in ((0.5, 1.0), (1.0, -1.0), (0.7, 1.0)):
        for turn in (sign, -sign):
            found.append(_move(now, half + ramp, share * velocity * turn, ramp))
            now += half + ramp + between
    # slowly to a pose, and back: what the image shows of it is rigid motion
    slow = max(0.8, 2.5 / frequency)
    speed = min(velocity, 0.8 * limits.angle_rad / slow)
    for turn in (1.0, -1.0):
        found.append(_move(now, slow, speed * turn, 0.25 * slow))
        now += slow + 0.7
    for turn in (1.0, -1.0):
        found.append(_move(now, half + ramp, velocity * turn, ramp))
        now += half + ramp
    return Scenario(duration_s=round(now + ring + strike_s, 3), moves=found)


def slowed(scenario: Scenario, share: float) -> Scenario:
    """The same moves at a part of their velocity."""
    return msgspec.structs.replace(
        scenario,
        moves=[msgspec.structs.replace(m, velocity_rad_s=share * m.velocity_rad_s) for m in scenario.moves],
    )


def _move(start_s: float, duration_s: float, velocity_rad_s: float, ramp_s: float) -> Move:
    return Move(round(start_s, 6), round(start_s + duration_s, 6), velocity_rad_s, ramp_s)
