"""A link behind a play: it coasts between the flanks, bounces off them, and is the motor where there is none."""

from math import exp, pi

import numpy as np
import pytest

from stillarm.diagnosis.physics.coasting_play import equivalent_behind_play, link_velocity

DT, DECAY, MOST = 1e-3, 2.0 * pi * 20.0, 1e9


def _move(on_s: float, total_s: float, speed: float = 0.3) -> np.ndarray:
    time = np.arange(round(total_s / DT)) * DT
    return np.where(time < on_s, speed, 0.0)


def test_between_the_flanks_it_coasts_as_its_friction_has_it() -> None:
    gap, drag = 0.1, 3.0
    rate = link_velocity(_move(0.5, 0.7), DT, DECAY, MOST, 0.0, gap, drag, 100.0, 0.7)
    stopped = round(0.55 / DT)  # the motor stands; the link crosses a play of 0.1 rad in a third of a second
    assert rate[stopped + 100] == pytest.approx(rate[stopped] * exp(-drag * 0.1), rel=1e-3)
    assert rate[stopped] > 0.25


def test_it_never_goes_far_beyond_the_flanks() -> None:
    command = np.concatenate([_move(0.5, 1.0), -_move(0.5, 1.0)])
    gap = 0.02
    rate = link_velocity(command, DT, DECAY, MOST, 0.0, gap, 1.0, 100.0, 0.1)
    motor = link_velocity(command, DT, DECAY, MOST, 0.0, 1e-9, 0.0, 200.0, 1.0)
    apart = DT * np.cumsum(motor - rate)
    assert 0.95 * gap < np.ptp(apart) < 1.1 * gap


def test_dull_teeth_do_not_bounce_and_springy_ones_do() -> None:
    def least(damping: float) -> float:
        """The velocity with which the link comes back from the flank ahead, after the motor has stopped."""
        return float(np.min(link_velocity(_move(0.5, 0.8), DT, DECAY, MOST, 0.0, 0.02, 0.0, 80.0, damping)))

    assert least(0.05) < -0.1
    assert least(1.0) > -0.05


def test_a_plain_drive_that_obeys_the_equivalent_command_moves_as_the_link() -> None:
    command = _move(0.2, 0.6)
    values = (0.01, 2.0, 90.0, 0.15)
    wanted = link_velocity(command, DT, DECAY, MOST, 0.0, *values)
    equivalent = equivalent_behind_play(command, DT, DECAY, MOST, 0.0, *values)
    omega, found = 0.0, []
    for aim in equivalent:
        omega = aim + (omega - aim) * exp(-DECAY * DT)
        found.append(omega)
    assert np.allclose(found, wanted, atol=1e-9)
