"""The force that a fit lacks where no sensor looks at the joint, against an oscillator that scipy integrates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stillarm.diagnosis.driven.fitting.fitting import fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.mechanisms.missing import missing_bend, missing_force
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

STEP_S, SAMPLES, W, ZETA, CUBIC = 0.005, 6000, 12.0, 0.03, 0.5


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["deflection", "acceleration"])
def test_a_stiffening_arm_shows_its_cubic_force_over_the_deflection(kind: str) -> None:
    """q'' + 2 zeta w q' + w^2 q + c q^3 = u; the linear model is the true one, so that -c q^3 is what it lacks."""
    times = np.arange(SAMPLES) * STEP_S
    tones = np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, 12)
    hz = np.linspace(1.2, 2.6, 12)

    def force(t: float) -> float:
        return float(np.sum(np.sin(2.0 * np.pi * hz * t + tones)))

    def slope(t: float, x: np.ndarray) -> list[float]:
        return [x[1], force(t) - 2.0 * ZETA * W * x[1] - W * W * x[0] - CUBIC * x[0] ** 3 * W * W]

    moved = solve_ivp(slope, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-9, atol=1e-12).y
    u = np.array([force(t) for t in times])
    bent = moved[0]
    if kind == "acceleration":
        bent = np.array([slope(t, x)[1] for t, x in zip(times, moved.T, strict=True)])
    seen = Output("deflection_m" if kind == "deflection" else "acceleration_m_s2", kind, bent, False, 0.0)  # type: ignore[arg-type]
    driven = Driven("x", STEP_S, 0.0, "joint_torque_command_n_m", u, False, (seen,), {})
    numbers = {
        "gain": -1.0, "damping": 0.0, "delay": 0.0, f"offset {seen.name}": 0.0, "log_w_1": float(np.log(W)),
        "zeta_1": ZETA, "follows_1": 1.0, "carries_1": 0.0,
    }  # fmt: skip
    fitted = fit(GreyBox(driven, irregular(driven.duration_s), modes=1), numbers, (), steps=0)
    found = missing_bend(fitted)
    assert found is not None and found.mode == 1 and missing_force(fitted) is None
    curve = found.over_angle
    wanted = -CUBIC * W * W * curve.at**3
    outer = np.abs(curve.at) > 0.5 * np.max(np.abs(curve.at))
    assert outer.sum() >= 6
    assert np.polyfit(wanted[outer], curve.mean[outer], 1)[0] == pytest.approx(1.0, abs=0.15)
    assert np.corrcoef(wanted, curve.mean)[0, 1] > 0.98
