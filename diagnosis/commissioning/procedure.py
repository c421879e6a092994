"""The procedure from the first nudge to the model: decides; what runs the moves and records them is handed in.

The same on a rig and in virtual time. Damping is off throughout: no scenario of the plan has a window in which it may
act.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from stillarm.common.files.model import Model, length_of
from stillarm.common.files.scenario import Scenario
from stillarm.common.user_error import UserError
from stillarm.diagnosis.calibration.calibrate import Calibration, calibrate
from stillarm.diagnosis.calibration.start_values import Start, start_values
from stillarm.diagnosis.commissioning.expect import fitted_to
from stillarm.diagnosis.commissioning.plan import Limits, moves, probe, slowed, stages, within
from stillarm.diagnosis.commissioning.verdict import CommissioningVerdict, judge
from stillarm.diagnosis.commissioning.watch import Bounds, Growth, bounds_of, exceeded, growth
from stillarm.diagnosis.data.measured import Frames, Measured

_MOST_REPEATS = 2  # of moves in which the controller missed its cycles
_SLOWER = 0.6  # of the velocity, after a bound has ended the moves
_TIME_CONSTANTS, _MOST_REST_S = 2.5, 60.0  # until the arm has rung down to a twelfth; of a rest
_LEAST_SIGNAL = 0.3  # power of the ringing over that of the noise

Recorder = Callable[[str, Scenario, Bounds], Measured]
"""Runs a scenario under a name, ends it where the bounds are exceeded, and gives what was recorded."""


@dataclass(frozen=True)
class Commissioning:
    """What was done, and what came of it."""

    grown: Growth
    rough: Start
    plan: Scenario
    measured: Measured
    found: Calibration
    verdict: CommissioningVerdict


def commission(
    record: Recorder,
    model: Model,
    limits: Limits,
    *,
    strike_s: float = 0.0,
    rest: Callable[[float], None] = lambda seconds: None,
    tell: Callable[[str], None] = lambda line: None,
    tick: Callable[[float, str], None] = lambda done, what: None,
) -> Commissioning:
    """Probe, plan, move, fit, judge. Raises UserError where the rig shows too little, or where a bound ends the moves.

    model: what is declared (length, the drive's limits, the sensors' ranges); its parameters may be badly wrong.
    strike_s: rest at the end in which the operator strikes the arm. rest: lets the arm ring down for so long, s.
    """
    length_of(model, "model")
    limits = within(limits, model.drive)
    bounds = bounds_of(limits, model.accelerometer.range_m_s2)
    tell("probe: the joint stands, then is nudged to and fro, in each stage twice as fast")
    probed = record("probe", probe(limits), bounds)
    grown = growth(probed, stages(limits), bounds)
    if grown.velocity_rad_s == 0.0:
        raise UserError(
            f"commission: even the smallest move ({stages(limits)[0].velocity_rad_s:g} rad/s) was too much or was cut "
            f"short: {grown.ended_by or 'the recording ends before it'}; `stillarm check` looks at sensor, camera and "
            "drive"
        )
    ended = f", ended by: {grown.ended_by}" if grown.ended_by else ""
    tell(f"moves up to {grown.velocity_rad_s:.3g} rad/s are safe{ended}")
    safe = [stage for stage in stages(limits) if stage.velocity_rad_s <= grown.velocity_rad_s]
    rough = start_values(until(probed, safe[-1].end_s), model)
    if rough is None or not rough.moved or rough.signal < _LEAST_SIGNAL:
        raise UserError(
            "commission: the moves left no vibration that the sensors show; see that the arm is free, that the drive "
            "moves it, and allow more (--max-velocity-rad-s, --max-angle-rad)"
        )
    mode = rough.model.arm.modes[0]
    tell(f"first mode near {mode.frequency_hz:.2f} Hz, damping near {100.0 * mode.damping_ratio:.1f} %")
    plan = fitted_to(moves(limits, grown.velocity_rad_s, mode, strike_s), rough.model, bounds)
    tell(f"moves: {plan.duration_s:.0f} s, in the second part of which the arm is left to ring")
    ring_down_s = min(_TIME_CONSTANTS / (mode.damping_ratio * mode.angular_frequency), _MOST_REST_S)
    for repeat in range(_MOST_REPEATS + 1):
        name = "moves" if repeat == 0 else f"moves_again_{repeat}"
        measured, plan = _moved(record, name, plan, bounds, lambda: rest(ring_down_s), tell)
        tell("fit: all parameters, by the simulation in free run")
        found = calibrate(measured, model, tick)
        verdict = judge(found, measured)
        if verdict.missed_s == 0.0 or repeat == _MOST_REPEATS:
            break
        tell(
            f"{verdict.text.partition(';')[0]}; the controller missed its cycles for {verdict.missed_s:.2g} s while "
            "the joint moved: the moves once more"
        )
        rest(ring_down_s)
    return Commissioning(grown, rough, plan, measured, found, verdict)


def _moved(
    record: Recorder,
    name: str,
    plan: Scenario,
    bounds: Bounds,
    ring_down: Callable[[], None],
    tell: Callable[[str], None],
) -> tuple[Measured, Scenario]:
    """The moves as recorded, and as they were planned. Where a bound ends them they are made once more, slower: the
    model that they were planned by is rough. Raises UserError where that is not enough, or the controller stopped."""
    measured = record(name, plan, bounds)
    over = exceeded(measured, bounds) if _cut_short(measured, plan) else None
    if over is not None:
        tell(f"{_ended(measured, plan)}: {over}; once more, at {_SLOWER:g} of the velocity")
        plan = slowed(plan, _SLOWER)
        ring_down()
        measured = record(f"{name}_slower", plan, bounds)
    if _cut_short(measured, plan):
        raise UserError(
            f"commission: {_ended(measured, plan)}: {exceeded(measured, bounds) or 'the controller was stopped'}; "
            "lower --max-velocity-rad-s or --max-angle-rad, or see to what was exceeded"
        )
    return measured, plan


def _cut_short(measured: Measured, plan: Scenario) -> bool:
    return measured.duration_s < plan.duration_s - 1.0


def _ended(measured: Measured, plan: Scenario) -> str:
    return f"the moves ended after {measured.duration_s:.0f} of {plan.duration_s:.0f} s"


def until(measured: Measured, end_s: float) -> Measured:
    """The recording's beginning."""
    n = min(measured.cycles, round(end_s / measured.cycle_s))
    frames = measured.frames
    seen = frames.received_s < n * measured.cycle_s
    return replace(
        measured,
        command=measured.command[:n],
        reference=measured.reference[:n],
        acceleration=measured.acceleration[:n],
        position=measured.position[:n],
        velocity=measured.velocity[:n],
        joint_age_s=measured.joint_age_s[:n],
        deflection=measured.deflection[:n],
        frames=Frames(
            frames.counter[seen],
            frames.received_s[seen],
            frames.started_s[seen],
            frames.displacement_px[seen],
            frames.captured_s[seen],
        ),
    )
