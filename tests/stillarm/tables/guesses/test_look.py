"""Guesses on tables made from equations: what is known comes out, and what cannot be known stays unknown."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.guesses.look import look
from stillarm.tables.table import Table

RATE_HZ = 500.0
ROWS = 6000
Array = NDArray[np.float64]


def smooth(seed: int, rows: int = ROWS) -> tuple[Array, Array]:
    """A random angle and its exact derivative: sines from 0.2 to 5 Hz."""
    random = np.random.default_rng(seed)
    time = np.arange(rows) / RATE_HZ
    angle, rate = np.zeros(rows), np.zeros(rows)
    for hz, phase in zip(random.uniform(0.2, 5.0, 12), random.uniform(0.0, 6.28, 12), strict=True):
        angle += np.sin(2.0 * np.pi * hz * time + phase) / hz
        rate += 2.0 * np.pi * np.cos(2.0 * np.pi * hz * time + phase)
    return 0.1 * angle, 0.1 * rate


def seen(columns: dict[str, Array], units: dict[str, str] | None = None) -> dict[str, ColumnLook]:
    return {column.name: column for column in look(Table("", columns, units or {})).columns}


TIME = np.arange(ROWS) / RATE_HZ


def test_without_names_a_derivative_is_found_and_its_role_left_open() -> None:
    angle, rate = smooth(1)
    noise = np.random.default_rng(0).normal(size=ROWS)
    found = seen({"column 1": TIME, "column 2": angle, "column 3": rate + 0.05 * rate.std() * noise})
    assert [found[f"column {i}"].quantity for i in (1, 2, 3)] == ["time", "position", "velocity"]
    assert found["column 2"].role == found["column 3"].role == "unknown"
    assert any("derivative of column 2, times 1" in why for why in found["column 3"].why)


@pytest.mark.parametrize("seed", range(5))
def test_two_signals_of_one_kind_are_no_derivatives_of_each_other(seed: int) -> None:
    one, _ = smooth(seed)
    other, _ = smooth(seed + 100)
    found = seen({"column 1": TIME, "column 2": one, "column 3": other})
    assert [found[f"column {i}"].quantity for i in (2, 3)] == ["unknown", "unknown"]


def test_one_frequency_alone_tells_nothing() -> None:
    """A delayed copy of a sine is as good as its derivative."""
    found = seen({"column 1": TIME, "column 2": np.sin(9.0 * TIME), "column 3": np.cos(9.0 * TIME)})
    assert found["column 2"].quantity == found["column 3"].quantity == "unknown"


def test_the_unit_of_a_rate_follows_from_its_state() -> None:
    angle, rate = smooth(2)
    found = seen({"t": TIME, "theta_deg": np.degrees(angle), "omega": np.degrees(rate), "w2": rate})
    assert found["omega"].unit == "deg/s" and found["omega"].role == "joint_velocity_rad_s"
    assert any("= 0.0174533 * omega" in why or "repeats omega" in why for why in found["w2"].why)


def test_an_encoder_in_rad_is_known_by_its_step() -> None:
    angle, _ = smooth(3)
    step = 2.0 * np.pi / 8192
    found = seen({"column 1": TIME, "column 2": np.round(angle / step) * step})["column 2"]
    assert (found.quantity, found.unit) == ("angle", "rad")


def test_a_converter_of_volts_is_no_encoder() -> None:
    """Its step 20 / 2^16 divides 360, too; only a step with pi in it proves an angle."""
    angle, _ = smooth(3)
    step = 20.0 / 2**16
    assert (
        seen({"column 1": TIME, "column 2": np.round(angle / step) * step})["column 2"].quantity == "unknown"
    )


def test_an_angle_that_fits_rad_and_deg_has_no_unit() -> None:
    angle, _ = smooth(4)
    assert seen({"t": TIME, "theta": angle})["theta"].unit == ""


def test_command_and_answer_in_one_matrix() -> None:
    torque, _ = smooth(5)
    measured = np.roll(torque, 4) + 0.01 * np.random.default_rng(1).normal(size=ROWS)
    found = seen({"current(:,1)": torque, "current(:,2)": measured})
    assert [found[f"current(:,{i})"].kind for i in (1, 2)] == ["command", "measured"]
    assert found["current(:,1)"].role == "motor_current_command_a"
    assert found["current(:,2)"].role == "motor_current_a"


def test_gravity_tells_the_unit_of_an_accelerometer() -> None:
    random = np.random.default_rng(2)
    axes = {
        f"acc{axis}": random.normal(size=ROWS) * 0.05 + offset
        for axis, offset in zip("XYZ", (0.1, 0.2, 0.97), strict=True)
    }
    assert {column.unit for column in seen(axes).values()} == {"g"}
    metric = {name: 9.80665 * values for name, values in axes.items()}
    assert {column.unit for column in seen(metric).values()} == {"m/s2"}


def test_of_a_nameless_pair_the_one_that_is_answered_is_the_input() -> None:
    random = np.random.default_rng(3)
    force = random.normal(size=20_000)
    answer = np.zeros(len(force))
    for n in range(2, len(force)):
        answer[n] = 1.9 * answer[n - 1] - 0.98 * answer[n - 2] + force[n - 1]
    found = seen({"column 1": answer, "column 2": force})
    assert (found["column 1"].role, found["column 2"].role) == ("output", "input")


@pytest.mark.parametrize("rows", [1000, 5000])
@pytest.mark.parametrize("seed", range(4))
def test_an_unrelated_pair_has_no_input(rows: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    noise = seen({"column 1": random.normal(size=rows), "column 2": random.normal(size=rows)})
    moves = seen({"column 1": smooth(seed, rows)[0], "column 2": smooth(seed + 50, rows)[0]})
    assert {column.role for column in (*noise.values(), *moves.values())} == {"unknown"}


def test_u_and_y_are_input_and_output_where_physics_does_not_tell() -> None:
    found = seen({"y": smooth(1)[0], "u": smooth(2)[0]})
    assert (found["u"].role, found["y"].role) == ("input", "output")


def test_time_rate_gaps_and_repeats() -> None:
    time = 1.7e12 + 5.0 * np.arange(400)
    time[200:] += 100.0
    time[300] = time[299]
    table = look(Table("", {"stamp": time.astype(np.int64), "x": smooth(6, 400)[0]}))
    assert table.clock is not None and (table.clock.unit, table.clock.zero) == ("ms", 1_700_000_000_000)
    assert table.sampling is not None and table.sampling.rate_hz == pytest.approx(200.0)
    assert (table.sampling.gaps, table.sampling.repeats) == (2, 1)


def test_a_counter_is_no_time() -> None:
    table = look(Table("", {"n": np.arange(500), "x": smooth(7, 500)[0]}))
    assert table.clock is None and table.columns[0].quantity == "count"


def test_a_clock_of_whole_seconds_gives_the_rate() -> None:
    table = look(
        Table(
            "", {"seconds": np.repeat(np.arange(12), 230), "accX": np.random.default_rng(4).normal(size=2760)}
        )
    )
    assert (
        table.clock is None and table.sampling is not None and table.sampling.rate_hz == pytest.approx(230.0)
    )


def test_a_model_with_an_encoders_step_was_measured() -> None:
    angle, rate = smooth(8)
    step = 2.0 * np.pi / 4096
    found = seen({"t": TIME, "x_sim(:,1)": np.round(angle / step) * step, "x_sim(:,2)": rate})
    assert found["x_sim(:,1)"].kind == found["x_sim(:,2)"].kind == "measured"


def test_columns_without_values_and_short_tables_are_looked_at() -> None:
    nothing = seen({"a": np.full(50, np.nan), "b": np.zeros(50)})
    assert {column.quantity for column in nothing.values()} == {"constant"}
    assert len(seen({"a": np.array([1.0]), "b": np.array([2.0])})) == 2
    assert len(seen({"a": np.array([1.0, 2.5, 3.0]), "b": np.array([2.0, 1.0, 7.0])})) == 2
