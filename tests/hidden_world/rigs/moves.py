"""What is done with the arm: velocities asked of the joint, a value a cycle, and forces at the tip, at steps' ends
and middles."""

from dataclasses import asdict, dataclass

import numpy as np

from tests.hidden_world.rigs.rig import STEP_S, TICK_S, Rig, Values, log_uniform, luck


@dataclass(frozen=True)
class Move:
    """at kind "impact": size is m/s; "release", "push": m/s^2 per mass of the first mode; else rad/s at the most."""

    kind: str
    start_s: float
    size: float
    ramp_s: float = 0.0
    hold_s: float = 0.0
    f0_hz: float = 0.0
    f1_hz: float = 0.0
    seed: int = 0

    @property
    def end_s(self) -> float:
        whole = {"step": 0.0, "doublet": 2.0, "impact": 0.0}.get(self.kind, 1.0)
        ramps = {"step": 2.0, "trapezoid": 2.0, "scurve": 2.0, "impact": 1.0, "push": 1.0, "release": 1.0}
        return self.start_s + ramps.get(self.kind, 0.0) * self.ramp_s + (whole or 1.0) * self.hold_s

    def told(self) -> dict[str, float | str]:
        """As truth.json has it."""
        told: dict[str, float | str] = {k: v for k, v in asdict(self).items() if v != 0.0 or k == "start_s"}
        unit = {"impact": "dv_m_s", "release": "force_m_s2", "push": "force_m_s2"}
        told[unit.get(self.kind, "velocity_rad_s")] = told.pop("size", 0.0)
        return told


JOINT = ("step", "trapezoid", "scurve", "doublet", "chirp", "multisine", "prbs", "rest")
TIP = ("impact", "release", "push")


def draw_moves(rig: Rig) -> list[Move]:
    """Moves of many kinds that keep the joint within rig.farthest_rad, one after another from about 1.5 s on."""
    chance = luck(rig.seed, 21)
    shares = chance.dirichlet([4.0, 4.0, 4.0, 1.2, 0.7, 0.5, 0.5, 0.4])
    touched = chance.random() < 0.5
    moves: list[Move] = []
    at, angle = float(chance.uniform(0.8, 2.5)), 0.0
    kinds = ["chirp"] if chance.random() < 0.7 else []
    if touched:
        kinds += [str(k) for k in chance.choice(TIP, int(chance.integers(1, 4)), p=[0.55, 0.3, 0.15])]
    places = {int(chance.integers(0, 9)): kind for kind in kinds}
    number = 0
    while True:
        kind = places.get(number) or str(chance.choice(JOINT, p=shares))
        move, angle_after = _draw(kind, rig, round(at, 3), angle, chance)
        if move.end_s > rig.duration_s - 1.5:
            return moves
        if kind != "rest":
            moves.append(move)
        angle = angle_after
        number += 1
        at = move.end_s + float(
            chance.uniform(0.6, 3.0) if chance.random() < 0.8 else chance.uniform(0.05, 0.6)
        )


def _draw(kind: str, rig: Rig, at: float, angle: float, chance: np.random.Generator) -> tuple[Move, float]:
    """A move of that kind, and the joint's angle after it."""
    side = -1 if angle + chance.uniform(-0.3, 0.3) * rig.farthest_rad > 0.0 else 1
    if kind in TIP:
        return _at_tip(kind, rig, at, chance), angle
    if kind == "rest":
        return Move(kind, at, 0.0, hold_s=float(chance.uniform(1.0, 4.0))), angle
    if kind in ("chirp", "multisine", "prbs"):
        return _lasting(kind, rig, at, side, chance), angle
    if kind == "doublet":
        hold = float(chance.uniform(0.3, 0.7)) / rig.modes[0].frequency_hz
        return Move(kind, at, side * rig.fastest_rad_s * log_uniform(chance, 0.05, 0.5), hold_s=hold), angle
    room = max(rig.farthest_rad - side * angle, 0.1 * rig.farthest_rad)
    travel = room * float(chance.uniform(0.1, 1.0))
    ramp = float(chance.uniform(0.08, 0.5)) * max(1.0, 1.5 / rig.modes[0].frequency_hz)
    ramp = 0.02 if kind == "step" else ramp
    speed = rig.fastest_rad_s * log_uniform(chance, 0.15, 1.0)
    hold = travel / speed - ramp
    if hold < 0.1:
        speed, hold = travel / (ramp + 0.1), 0.1
    speed, hold = min(speed, rig.fastest_rad_s), min(hold, 2.0)
    return Move(kind, at, side * speed, ramp_s=ramp, hold_s=hold), angle + side * speed * (ramp + hold)


def _at_tip(kind: str, rig: Rig, at: float, chance: np.random.Generator) -> Move:
    """An impact, a push by hand, or a slow pull and its release: it bends the arm about as much as joint moves do."""
    f = rig.modes[0].frequency_hz
    w = 2.0 * np.pi * f
    bend = log_uniform(chance, 0.15, 1.0) * rig.modes[0].participation * rig.length_m * rig.fastest_rad_s / w
    bend *= float(chance.choice([-1, 1]))
    if kind == "impact":
        return Move(kind, at, bend * w, ramp_s=float(chance.uniform(0.002, 0.012)))
    if kind == "release":
        ramp = max(0.3, 2.0 / f) * float(chance.uniform(0.7, 2.0))
        return Move(kind, at, bend * w * w, ramp_s=ramp, hold_s=float(chance.uniform(0.0, 2.0)))
    return Move(kind, at, bend * w * w, ramp_s=float(chance.uniform(0.3, 1.5)) / f)


def _lasting(kind: str, rig: Rig, at: float, side: int, chance: np.random.Generator) -> Move:
    """What shakes the joint for some seconds about where it is."""
    f, hold = rig.modes[0].frequency_hz, float(chance.uniform(4.0, 9.0))
    f0, f1 = f * float(chance.uniform(0.2, 0.5)), f * float(chance.uniform(1.8, 3.5))
    size = rig.fastest_rad_s * log_uniform(chance, 0.02, 0.12)
    size = min(size, 0.3 * rig.farthest_rad * 2.0 * np.pi * f0)
    seed = int(chance.integers(1, 2**31))
    if kind == "prbs":
        return Move(kind, at, size, hold_s=hold, f0_hz=float(chance.uniform(1.0, 3.0)) * f, seed=seed)
    return Move(kind, at, side * size, hold_s=hold, f0_hz=f0, f1_hz=f1, seed=seed)


def command(moves: list[Move], cycles: int) -> Values:
    """The velocity asked of the joint at each cycle, rad/s."""
    t = np.arange(cycles) * TICK_S
    out = np.zeros(cycles)
    for move in moves:
        if move.kind in TIP:
            continue
        inside = (t >= move.start_s) & (t < move.end_s)
        out[inside] += move.size * _shape(move, t[inside] - move.start_s)
    return out


def _shape(move: Move, t: Values) -> Values:
    if move.kind in ("step", "trapezoid", "scurve"):
        x = np.clip(np.minimum(t, 2.0 * move.ramp_s + move.hold_s - t) / move.ramp_s, 0.0, 1.0)
        return np.asarray(x if move.kind != "scurve" else x * x * (3.0 - 2.0 * x))
    if move.kind == "doublet":
        return np.where(t < move.hold_s, 1.0, -1.0)
    fade = np.clip(np.minimum(t, move.hold_s - t) / 0.3, 0.0, 1.0)
    if move.kind == "chirp":
        phase = move.f0_hz * t + 0.5 * (move.f1_hz - move.f0_hz) * t * t / move.hold_s
        return np.asarray(fade * np.sin(2.0 * np.pi * phase))
    chance = np.random.default_rng((move.seed, 22))
    if move.kind == "prbs":
        chips = chance.choice([-1.0, 1.0], int(move.hold_s * move.f0_hz) + 2)
        chips -= np.mean(chips)
        return np.asarray(chips[(t * move.f0_hz).astype(int)])
    tones = np.exp(chance.uniform(np.log(move.f0_hz), np.log(move.f1_hz), 7))
    phases = chance.uniform(0.0, 2.0 * np.pi, 7)
    return np.asarray(
        fade * np.mean([np.sin(2.0 * np.pi * f * t + p) for f, p in zip(tones, phases, strict=True)], axis=0)
    )


def tip_force(moves: list[Move], steps: int) -> Values:
    """Force at the tip per mass of the first mode, m/s^2, shape (2 steps + 1,)."""
    t = np.arange(2 * steps + 1) * (0.5 * STEP_S)
    out = np.zeros(len(t))
    for move in moves:
        if move.kind not in TIP:
            continue
        inside = slice(int(move.start_s / (0.5 * STEP_S)), int((move.end_s + 0.01) / (0.5 * STEP_S)) + 1)
        since = t[inside] - move.start_s
        if move.kind == "release":
            x = np.clip(since / move.ramp_s, 0.0, 1.0)
            gone = np.clip((since - move.ramp_s - move.hold_s) / 0.002, 0.0, 1.0)  # let go within 2 ms
            out[inside] += move.size * x * x * (3.0 - 2.0 * x) * 0.5 * (1.0 + np.cos(np.pi * gone))
        else:
            x = np.clip(since / move.ramp_s, 0.0, 1.0)
            peak = move.size * np.pi / (2.0 * move.ramp_s) if move.kind == "impact" else move.size
            out[inside] += peak * np.sin(np.pi * x)
    return out
