"""What `--look` writes, `--as` obeys: for any table, without a word from the user."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.recording.reader import open_recording
from stillarm.tables.described import described
from stillarm.tables.description import parse_description
from stillarm.tables.drawing import draw
from stillarm.tables.guesses.look import look
from stillarm.tables.importing import import_tables
from stillarm.tables.report import column_rows, head_lines
from stillarm.tables.table import Table, TableFile, Values

NAMES = (
    "t",
    "time [ms]",
    "theta",
    "omega [deg/s]",
    "acc",
    'odd "name"\\',
    "i_cmd",
    "tau (Nm)",
    "frame",
    "received_s",
)
NAMES += (
    "displacement_px",
    "strain",
    "input",
    "V1",
    "started_s",
    "joint_position_rad",
    "deflection",
    "motor_current_a",
)


def column(kind: str, rows: int, random: np.random.Generator) -> Values:
    """Values of one kind."""
    made: dict[str, Values] = {
        "time": 5.0 + 0.01 * np.arange(rows),
        "epoch": 1_700_000_000_000_000_000 + 1_000_000 * np.arange(rows),
        "counter": np.arange(rows),
        "noise": random.normal(size=rows),
        "huge": random.normal(size=rows) * 1e14,
        "still": np.full(rows, 3.0),
        "nothing": np.full(rows, np.nan),
        "gaps": np.where(random.random(rows) < 0.3, np.nan, random.normal(size=rows)),
        "walk": np.cumsum(random.normal(size=rows)),
        "flag": random.integers(0, 2, rows),
        "steps": np.round(random.normal(size=rows) * 50.0) * 2.0 * np.pi / 4096,
    }
    return made[kind]


KINDS = ("time", "epoch", "counter", "noise", "huge", "still", "nothing", "gaps", "walk", "flag", "steps")


@pytest.mark.slow
@given(
    tables=st.lists(
        st.tuples(
            st.integers(1, 300),
            st.dictionaries(st.sampled_from(NAMES), st.sampled_from(KINDS), min_size=1, max_size=7),
        ),
        min_size=1,
        max_size=3,
    ),
    kind=st.sampled_from(["csv", "mcap"]),
    seed=st.integers(0, 99),
)
@settings(max_examples=120, deadline=None)
def test_any_table_comes_in_as_it_was_looked_at(
    tmp_path_factory: pytest.TempPathFactory, tables: list[tuple[int, dict[str, str]]], kind: str, seed: int
) -> None:
    random = np.random.default_rng(seed)
    many = len(tables) > 1
    held = tuple(
        Table(f"/{number}" if many else "", {name: column(k, rows, random) for name, k in kinds.items()})
        for number, (rows, kinds) in enumerate(tables)
    )
    file = TableFile("any", kind, held)
    looks = tuple(look(table) for table in held)
    for seen in looks:
        assert head_lines(seen) and len(column_rows(seen)) == len(seen.columns)
    made = described(file, looks)
    again = parse_description(made.text, "again")
    assert again == made.description
    if all(c.role == "ignore" for entry in again.tables for c in entry.channels):
        return  # a clock alone: nothing to import
    out = tmp_path_factory.mktemp("any") / "rec.mcap"
    import_tables(file, again, made.text, out)
    assert open_recording(out).counts


@pytest.mark.slow
def test_the_picture_shows_gaps_and_long_columns(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    held = Table(
        "",
        {
            "t": 0.001 * np.arange(20_000),
            **{k: column(k, 20_000, random) for k in ("gaps", "walk", "nothing")},
        },
    )
    draw(TableFile("any", "csv", (held,)), (look(held),), tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000
