"""Identification compared with its peers on the same data: `stillarm benchmark identification`.

PySINDy (sparse regression of x' on monomials of y, y', u), SysIdentPy (polynomial NARX by forward regression), a plain
linear subspace fit and ours use the same input and output, and are scored by the same error: a free run over data that
none of them has fitted. The benchmark also compares the simulation with scipy's solve_ivp. Install the peers with
pip install stillarm[peers].
"""

import tempfile
import time
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.identification_data import Pair, pairs
from stillarm.benchmarks.identification_driven import as_driven
from stillarm.benchmarks.subspace_peer import best_subspace
from stillarm.common.csv_bundle.mapped_data import import_mapped
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.diagnose import diagnose
from stillarm.diagnosis.report.result import Result
from stillarm.simulation.arm.compiled_laws import laws_of
from stillarm.simulation.arm.free_run import free_run
from stillarm.simulation.arm.state import make_arm

Array = NDArray[np.float64]

_DEGREE = 3
_SINDY_THRESHOLDS = (0.0, 1e-4, 1e-3, 5e-3, 2e-2, 1e-1)  # of the speed's deviation
_NARX = ((2, 8), (2, 14), (3, 14), (3, 24))  # lags, terms


def compare(pair: Pair) -> list[dict[str, Any]]:
    """A row for each method: its result, its held-out error in free run, and its time."""
    rows = []
    ours = as_driven if pair.accelerates else _ours
    methods = (
        ("stillarm", ours),
        ("subspace", _subspace),
        ("PySINDy", _pysindy),
        ("SysIdentPy", _sysidentpy),
    )
    for name, method in methods:
        began, spent = time.perf_counter(), time.process_time()
        try:
            shown, returned = method(pair)
        except ImportError as error:
            rows.append(
                _row(pair, name, None, f"not installed ({error.name}): pip install stillarm[peers]", 0.0, 0.0)
            )
            continue
        rows.append(
            _row(pair, name, shown, returned, time.perf_counter() - began, time.process_time() - spent)
        )
    return rows


def _row(
    pair: Pair, method: str, shown: Array | None, returned: str, seconds: float, cpu: float
) -> dict[str, Any]:
    """shown: simulated output over the test span; not finite if the model diverged."""
    row: dict[str, Any] = {"data": pair.name, "method": method, "error_rms": None, "nrmse": None}
    if shown is not None:
        y = pair.y[pair.test]
        error = shown - y
        stayed = bool(np.isfinite(error).all()) and float(np.max(np.abs(error))) < 1e3 * float(np.std(y))
        if stayed:
            row["error_rms"] = float(np.sqrt(np.mean(error**2)))
            row["nrmse"] = row["error_rms"] / float(np.std(y))
        else:
            returned += " (free run diverges)"
    return row | {"seconds": seconds, "cpu_s": cpu, "returned": returned}


def _ours(pair: Pair) -> tuple[Array, str]:
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "pair.mcap"
        rows = np.column_stack((pair.u, pair.y))
        data = Path(folder) / "pair.csv"
        np.savetxt(data, rows, delimiter=",", header="input,output", comments="", fmt="%.9g")
        import_mapped(data, {"input": "input", "output": "output"}, pair.rate_hz, recording)
        span = (pair.test.start / pair.rate_hz, pair.test.stop / pair.rate_hz)
        model = Model(arm=Arm(modes=[Mode(frequency_hz=_peak_hz(pair))]))
        found = diagnose(recording, model, hold_out=[span])
    assert isinstance(found, Result)  # a pair has no joint of its own
    said = []
    for one in found.table["findings"]:
        values = ", ".join(
            f"{name} = {value['value']:.4g} +- {value['std']:.2g}"
            for name, value in one["parameters"].items()
        )
        said.append(f"{one['cause']} ({values})")
    text = f"{found.table['verdict']}: {'; '.join(said) or 'no cause'}"
    return found.found.final.predicted.channels["deflection"][pair.test], text


def _subspace(pair: Pair) -> tuple[Array, str]:
    shown, order = best_subspace(pair.u, pair.y, pair.train, pair.test)
    return shown, f"linear, of order {order}"


def _peak_hz(pair: Pair) -> float:
    """Frequency of the largest output / input over the training span: the resonance, as a user would read it."""
    from scipy.signal import welch

    hz, out = welch(pair.y[pair.train], pair.rate_hz, nperseg=4096)
    _, into = welch(pair.u[pair.train], pair.rate_hz, nperseg=4096)
    driven = into > 0.1 * np.max(into)
    return float(hz[np.argmax(np.where(driven, out / np.maximum(into, 1e-300), 0.0))])


def _pysindy(pair: Pair) -> tuple[Array, str]:
    """Uses the threshold whose free run is best over the last tenth of the training span."""
    import pysindy as ps
    from scipy.interpolate import CubicSpline

    dt = 1.0 / pair.rate_hz
    scale_y, scale_u = float(np.std(pair.y)), float(np.std(pair.u))
    y, u = pair.y / scale_y, pair.u / scale_u
    spline = CubicSpline(np.arange(len(y)) * dt, y)
    velocity, acceleration = spline(spline.x, 1), spline(spline.x, 2)
    rate = float(np.std(velocity))
    x, x_dot = np.column_stack((y, velocity / rate)), np.column_stack((velocity, acceleration / rate))
    train, check = _tenth_off(pair.train)
    best: tuple[float, Array, int] | None = None
    powers = np.empty(0)
    for share in _SINDY_THRESHOLDS:
        library = ps.PolynomialLibrary(degree=_DEGREE)
        model = ps.SINDy(optimizer=ps.STLSQ(threshold=share * rate), feature_library=library)
        model.fit(x[train], t=dt, x_dot=x_dot[train], u=u[train][:, None])
        weights, powers = np.asarray(model.coefficients()), np.asarray(library.powers_)
        error = _miss(_free_run(weights, powers, u[check], x[check][0], dt), y[check])
        if best is None or error < best[0]:
            best = (error, weights, int(np.count_nonzero(weights)))
    assert best is not None
    shown = _free_run(best[1], powers, u[pair.test], x[pair.test][0], dt)
    return shown * scale_y, f"{best[2]} terms without names in y, y', u"


def _tenth_off(span: slice) -> tuple[slice, slice]:
    """A span without its last tenth, and that tenth."""
    cut = span.stop - (span.stop - span.start) // 10
    return slice(span.start, cut), slice(cut, span.stop)


def _miss(shown: Array, y: Array) -> float:
    """Mean square error; infinite for a diverged run."""
    error = float(np.mean((shown - y) ** 2))
    return error if np.isfinite(error) else float("inf")


def _free_run(weights: Array, powers: Array, u: Array, state: Array, dt: float) -> Array:
    """x' = weights (monomials of x and u) by fourth-order Runge-Kutta, with interpolated input."""

    def slope(x: Array, force: float) -> Array:
        found: Array = weights @ np.prod(np.array([x[0], x[1], force]) ** powers, axis=1)
        return found

    shown = np.full(len(u), np.nan)
    with np.errstate(all="ignore"):
        for k in range(len(u)):
            shown[k] = state[0]
            if not np.all(np.abs(state) < 1e3):
                break
            now, then = u[k], u[min(k + 1, len(u) - 1)]
            a = slope(state, now)
            b = slope(state + 0.5 * dt * a, 0.5 * (now + then))
            c = slope(state + 0.5 * dt * b, 0.5 * (now + then))
            d = slope(state + dt * c, then)
            state = state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return shown


def _sysidentpy(pair: Pair) -> tuple[Array, str]:
    """Uses the lags and the number of terms whose free run is best over the last tenth of the training span."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    u, y = pair.u[:, None], pair.y[:, None]
    train, check = _tenth_off(pair.train)
    best: tuple[float, Any, str] | None = None
    for lags, terms in _NARX:
        model = FROLS(
            order_selection=False,
            n_terms=terms,
            ylag=lags,
            xlag=lags,
            basis_function=Polynomial(degree=_DEGREE),
        )
        model.fit(X=u[train], y=y[train])
        error = _miss(np.asarray(model.predict(X=u[check], y=y[check])).ravel(), pair.y[check])
        if best is None or error < best[0]:
            best = (error, model, f"{terms} terms without names in {lags} past y and u")
    assert best is not None
    return np.asarray(best[1].predict(X=u[pair.test], y=y[pair.test])).ravel(), best[2]


def simulation_speed() -> dict[str, float]:
    """60 s at 1 kHz with two modes: the time of our simulation, and of solve_ivp on a tenth of it."""
    from scipy.integrate import solve_ivp

    n, dt, length = 60_000, 0.001, 2.0
    modes = np.array([[2.6, 0.01, 1.14], [16.0, 0.01, -0.2]])
    command = np.repeat(0.2 * np.random.default_rng(1).standard_normal(n // 500), 500)
    drive = Drive(dead_time_s=0.0, max_acceleration_rad_s2=1e9, min_position_rad=-1e9, max_position_rad=1e9)
    pushed = modes * (1.0, 1.0, length)
    joint, motor = np.empty((n, 4)), np.empty((n, 2))
    q, qdd = np.empty((n, 2)), np.empty((n, 2))
    first, still = np.zeros(1, np.int64), np.zeros((1, 2, 2))

    def once() -> None:
        arm, whole = make_arm(drive, dt, pushed, laws_of([]))
        free_run(arm, command, whole, first, still, joint, motor, q, qdd)

    once()
    ours = min(_timed(once) for _ in range(5))
    w, zeta, push = 2 * pi * modes[:, 0], modes[:, 1], modes[:, 2] * length

    def slope(t: float, x: Array) -> Array:
        alpha = 2 * pi * 20.0 * (command[min(int(t / dt + 1e-9), n - 1)] - x[0])
        return np.array(
            [alpha, x[2], -w[0] ** 2 * x[1] - 2 * zeta[0] * w[0] * x[2] - push[0] * alpha,
             x[4], -w[1] ** 2 * x[3] - 2 * zeta[1] * w[1] * x[4] - push[1] * alpha]
        )  # fmt: skip

    part = n // 10
    results: list[Any] = []

    def theirs() -> None:
        results.append(
            solve_ivp(
                slope,
                (0.0, part * dt),
                np.zeros(5),
                rtol=1e-6,
                atol=1e-9,
                max_step=0.005,
                t_eval=np.arange(part) * dt,
            )
        )

    scipy_s = 10.0 * _timed(theirs)
    apart = float(np.max(np.abs(results[-1].y[1] - q[:part, 0])) / np.max(np.abs(q[:part, 0])))
    return {
        "simulated_s": n * dt,
        "ours_s": ours,
        "times_real_time": n * dt / ours,
        "solve_ivp_s": scipy_s,
        "solve_ivp_times_real_time": n * dt / scipy_s,
        "largest_difference": apart,
    }


def _timed(what: Callable[[], None]) -> float:
    began = time.perf_counter()
    what()
    return time.perf_counter() - began


def run_all(data: Path | None, progress: Callable[[float], None] = lambda done: None) -> dict[str, Any]:
    """The result file: rows of the comparison, and the simulation's speed. data: folder of the measured data."""
    speed = simulation_speed()
    progress(0.1)
    found = pairs(data) if data is not None else []
    if data is not None and not found:
        raise UserError(
            f"--data {data}: contains none of silverbox/SNLS80mV.csv, robot_arm/robot_arm.dat and "
            "f16_vibration/f-16.txt; omit --data to measure the speed alone"
        )
    rows = []
    for number, pair in enumerate(found, 1):
        rows += compare(pair)
        progress(0.1 + 0.9 * number / len(found))
    progress(1.0)
    return {"rows": rows, "simulation": speed}
