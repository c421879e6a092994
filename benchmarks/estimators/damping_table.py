"""The second table: closed loop with each method, with an oracle, and without damping."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import nan, sqrt
from typing import Any

import numpy as np

from stillarm.benchmarks.estimators.closed_loop import NO_DAMPING, ORACLE, Course, Run, run_closed
from stillarm.benchmarks.estimators.tables import failure_of
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, REGIMES, Arm

REGIMES_DAMPED = ("freerun drift", "triggered jitter")
NOISE = 0.3
SETTLED = 0.1  # of the struck amplitude
DISTURBED = 0.3  # rms deflection under the steady random force without damping, over the amplitude
_ON_S = 5.0  # until then the arm rings freely, while the methods estimate the delay
_STRIKES_S = (8.0, 12.0, 16.0, 20.0)
_RING_S, _DISTURBED_S = 24.0, 40.0
_STEADY_S = 10.0


@dataclass(frozen=True)
class DampingJob:
    """One trial in closed loop, for all methods, the oracle and no damping."""

    regime: str
    trial: int
    seed: int
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Damped:
    """Results by method: settling time, s (NaN: did not settle); residual rms deflection / amplitude."""

    job: DampingJob
    settling_s: dict[str, float]
    residual: dict[str, float]
    failures: dict[str, str]


def damp(job: DampingJob) -> Damped:
    """Run strikes, and a random disturbance, with every method."""
    arm, regime = Arm(), REGIMES[job.regime]
    unit, force = arm.amplitude_m, steady_force_m_s2(arm)
    struck = Course(_RING_S, dict.fromkeys((0.0, *_STRIKES_S), unit), damping=lambda t: t >= _ON_S)
    disturbed = Course(_DISTURBED_S, {0.0: unit}, damping=lambda t: t >= _ON_S, force_std_m_s2=force)
    settling, residual, failures = {}, {}, {}
    for name in (*job.methods, ORACLE, NO_DAMPING):
        try:
            run = run_closed(name, regime, NOISE, (job.seed, job.trial, 1), struck)
            settling[name] = settling_time_s(run, unit)
            run = run_closed(name, regime, NOISE, (job.seed, job.trial, 2), disturbed)
            steady = run.deflection_m[round(_STEADY_S / CYCLE_S) :]
            residual[name] = float(np.sqrt(np.mean(steady**2))) / unit
        except Exception as failure:  # an exception is the result of this method alone
            failures[name] = f"{type(failure).__name__}: {failure}"
    return Damped(job, settling, residual, failures)


def steady_force_m_s2(arm: Arm) -> float:
    """Standard deviation of the random force, independent in each cycle, that sustains DISTURBED of the amplitude.

    A white force of density S sustains a variance of S / (4 zeta w^3). Held over a cycle, S = variance * cycle.
    """
    return DISTURBED * arm.amplitude_m * sqrt(4.0 * arm.damping_ratio * arm.angular_frequency**3 / CYCLE_S)


def settling_time_s(run: Run, struck_m: float) -> float:
    """Mean time from a strike until the amplitude stays below SETTLED of the struck one; NaN if it once did not."""
    times = []
    for strike, until in zip(_STRIKES_S, (*_STRIKES_S[1:], _RING_S), strict=True):
        first, last = round(strike / CYCLE_S), round(until / CYCLE_S)
        above = np.flatnonzero(run.amplitude_m[first:last] > SETTLED * struck_m)
        times.append(nan if above[-1] == last - first - 1 else CYCLE_S * float(above[-1] + 1))
    return float(np.mean(times))


def damping_rows(damped: Iterable[Damped]) -> list[dict[str, Any]]:
    """A row for each regime and method: means over the trials, and ratios to the oracle; None: did not settle."""
    cells: dict[str, list[Damped]] = {}
    for one in damped:
        cells.setdefault(one.job.regime, []).append(one)
    rows = []
    for regime, cell in cells.items():
        for name in (*cell[0].job.methods, ORACLE, NO_DAMPING):
            done = [one for one in cell if name in one.residual]
            settling = _mean(one.settling_s[name] for one in done)
            residual = _mean(one.residual[name] for one in done)
            rows.append(
                {
                    "method": name,
                    "regime": regime,
                    "noise": NOISE,
                    "settling_time_s": settling,
                    "settling_over_oracle": _over(settling, _mean(one.settling_s[ORACLE] for one in done)),
                    "residual": residual,
                    "residual_over_oracle": _over(residual, _mean(one.residual[ORACLE] for one in done)),
                    "trials": len(done),
                    "failure": failure_of(one.failures.get(name) for one in cell),
                }
            )
    return rows


def _mean(values: Iterable[float]) -> float | None:
    known = np.array(list(values))
    return float(known.mean()) if len(known) and np.isfinite(known).all() else None


def _over(value: float | None, reference: float | None) -> float | None:
    return None if value is None or reference is None else value / reference
