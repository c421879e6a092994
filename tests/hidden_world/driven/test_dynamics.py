"""The motion against what mechanics gives in closed form, and against itself in finer steps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from tests.hidden_world.driven.departure import Plain
from tests.hidden_world.driven.draw import draw_rig
from tests.hidden_world.driven.dynamics import LINK, LINK_W, MOTOR, MOTOR_W, STATES, Laws, Q, V, kinetics
from tests.hidden_world.driven.recording import laws_of, record
from tests.hidden_world.driven.rig import PARTICIPATIONS, Arm, Effect, Values

RATE = 200.0
ARM = Arm(0.8, 0.5, (4.0, 25.0), (0.0, 0.0), 0.1)
RIGID = np.array([[0.2]])
NONE = np.zeros(0)


def moved(
    laws: Laws,
    wanted: Values,
    mass: Values = RIGID,
    modes: tuple[Values, Values] = (NONE, NONE),
    **more: object,
) -> Values:
    """States at each sample."""
    seen = np.zeros((len(wanted), 2))
    _, states, step = kinetics(wanted, seen, RATE, laws, mass, *modes, **more)  # type: ignore[arg-type]
    return states[:: round(1.0 / (RATE * step))]


def test_a_rigid_joint_speeds_up_as_in_closed_form() -> None:
    rows = moved(Laws(gain=0.5, viscous=0.3, back_emf=0.1), np.full(400, 2.0))
    t = np.arange(401) / RATE
    assert np.allclose(rows[:, LINK_W], 2.5 * (1.0 - np.exp(-2.0 * t)), atol=1e-9)
    assert np.allclose(rows[:, LINK], 2.5 * (t - (1.0 - np.exp(-2.0 * t)) / 2.0), atol=1e-9)


def test_dry_friction_brakes_evenly_and_then_holds() -> None:
    start = np.zeros(STATES)
    start[MOTOR_W] = start[LINK_W] = 1.0
    rows = moved(Laws(1.0, dry_up=0.1, dry_down=0.1, dry_width=1e-3), np.zeros(600), start=start)
    t = np.arange(601) / RATE
    moving = t < 1.95
    assert np.allclose(rows[moving, LINK_W], 1.0 - 0.5 * t[moving], atol=1e-6)
    assert np.max(np.abs(rows[t > 2.1, LINK_W])) < 1e-6


@pytest.mark.parametrize("up, down", [(0.1, 0.05), (0.05, 0.1)])
def test_dry_friction_differs_by_direction(up: float, down: float) -> None:
    lost = []
    for speed in (1.0, -1.0):
        start = np.zeros(STATES)
        start[MOTOR_W] = start[LINK_W] = speed
        rows = moved(Laws(1.0, dry_up=up, dry_down=down), np.zeros(100), start=start)
        lost.append((1.0 - abs(rows[-1, LINK_W])) * 0.2 / 0.5)
    assert lost == pytest.approx([up, down], rel=1e-5)


def test_a_free_arm_keeps_its_energy() -> None:
    mass, stiffness = ARM.mass_matrix(0.05), ARM.stiffness()
    start = np.zeros(STATES)
    start[Q], start[Q + 1] = 0.02, 0.003
    rows = moved(Laws(1.0), np.zeros(1000), mass, (np.zeros(2), stiffness), start=start)
    speeds = np.stack([rows[:, LINK_W], rows[:, V], rows[:, V + 1]], axis=1)
    energy = 0.5 * np.einsum("ri,ij,rj->r", speeds, mass, speeds)
    energy += 0.5 * rows[:, [Q, Q + 1]] ** 2 @ stiffness
    assert np.ptp(energy) < 1e-5 * energy[0]


def test_the_arm_moves_as_another_integrator_moves_it() -> None:
    """scipy's DOP853 on the same equations, written with matrices, under a steady torque and gravity."""
    mass, damping, stiffness = ARM.mass_matrix(0.05), np.array([0.02, 0.05]), ARM.stiffness()
    laws = Laws(1.0, viscous=0.2, gravity=0.7, ripple=0.05, ripple_turns=9.0, ripple_phase=0.4)
    mine = moved(laws, np.full(400, 0.3), mass, (damping, stiffness))

    def slope(_t: float, x: Values) -> Values:
        torque = 0.3 - 0.2 * x[3] - 0.7 * np.sin(x[0]) + 0.05 * np.sin(9.0 * x[0] + 0.4)
        force = np.array([torque, *(-damping * x[4:6] - stiffness * x[1:3])])
        return np.concatenate([x[3:6], np.linalg.solve(mass, force)])

    its = solve_ivp(slope, (0.0, 2.0), np.zeros(6), "DOP853", np.arange(401) / RATE, rtol=1e-10, atol=1e-12)
    assert np.allclose(mine[:, [LINK, Q, Q + 1]], its.y[:3].T, atol=1e-7)


def test_half_the_step_changes_nothing_that_a_sensor_sees() -> None:
    for seed in range(6):
        rig, _ = draw_rig(seed, "none", longest_s=4.0)
        seen = np.zeros((rig.rows, 2))
        mass = rig.arm.mass_matrix(rig.drive.hub_inertia + rig.drive.motor_inertia)
        arm, wanted = (rig.arm.damping(), rig.arm.stiffness()), rig.excitation.values
        _, coarse, _ = kinetics(wanted, seen, rig.rate_hz, laws_of(rig), mass, *arm)
        _, fine, _ = kinetics(wanted, seen, rig.rate_hz, laws_of(rig), mass, *arm, finer=2)
        assert np.allclose(coarse, fine[::2], rtol=1e-4, atol=1e-4 * np.max(np.abs(coarse[:, LINK])))


def test_play_lets_the_motor_turn_by_the_gap() -> None:
    laws = Laws(1.0, gear_inertia=0.05, gap=0.02, gear_stiffness=5e3, gear_damping=5.0, viscous=0.5)
    wanted = np.repeat([0.5, -0.5], 300)
    rows = moved(laws, wanted, np.array([[0.15]]))
    apart = rows[:, MOTOR] - rows[:, LINK]
    assert apart[250] == pytest.approx(0.01, abs=2e-4) and apart[550] == pytest.approx(-0.01, abs=2e-4)


def test_modes_are_those_of_a_clamped_free_beam() -> None:
    """Roots and shapes of cos x cosh x = -1."""
    for root, stated in zip((1.8751041, 4.6940911), PARTICIPATIONS, strict=True):
        sigma = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))

        def shape(x: float, root: float = root, sigma: float = sigma) -> float:
            k = root * x
            return float(np.cosh(k) - np.cos(k) - sigma * (np.sinh(k) - np.sin(k)))

        square = quad(lambda x, shape=shape: shape(x) ** 2, 0.0, 1.0)[0]
        first = quad(lambda x, shape=shape: x * shape(x), 0.0, 1.0)[0]
        assert square / shape(1.0) ** 2 == pytest.approx(0.25, abs=1e-5)
        assert first * shape(1.0) / square == pytest.approx(stated, abs=2e-4)


def test_the_stated_modes_move_the_arm_alike() -> None:
    """The joint's equation from what is stated: inertia, and each mode's mass and participation."""
    modes, mass = ARM.clamped_modes(), ARM.mass_matrix(0.05)
    effective = mass[0, 0] - sum(m["modal_mass_kg"] * (m["participation"] * ARM.length_m) ** 2 for m in modes)
    assert effective == pytest.approx(1.0 / np.linalg.inv(mass)[0, 0], rel=1e-9)
    assert modes[0]["frequency_hz"] < ARM.frequencies_hz[0]


def test_a_refit_takes_up_the_rigs_own_parameters() -> None:
    rig, _ = draw_rig(3, "none", longest_s=10.0)
    plain = Plain(rig)
    off = replace(rig, drive=replace(rig.drive, viscous=1.02 * rig.drive.viscous, gain=1.01 * rig.drive.gain))
    changed = record(off, noise=False)
    raw, rest = (max(plain.departures(changed, refit).values()) for refit in (False, True))
    assert rest < 0.05 * raw


def test_a_size_of_nothing_changes_nothing() -> None:
    rig, _ = draw_rig(5, "none", longest_s=4.0)
    for cause in ("joint_coulomb_friction", "torque_ripple", "amplifier_dead_zone", "torque_offset"):
        one = record(rig, Effect(cause, "symmetric", 0.0), noise=False)
        assert np.array_equal(one.states, record(rig, noise=False).states)
