"""What `import --look` guesses on the measured data beside the repository, and what is known: docs/import.md's table.

The truth is what ../shared/data/README.md, the files' own names and their sources say. The table is printed by
`python -m tests.stillarm.tables.truth`. A guess is right if quantity, command or measurement, and unit are, each where
the truth is known.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.guesses.look import look
from stillarm.tables.readers.read_file import read_table_file

DATA = Path(__file__).parents[3] / "shared" / "data"
NOT_STATED = "not stated"


@dataclass(frozen=True)
class Known:
    """quantities: any of these is right. kind, unit: empty where nothing is known of them."""

    quantities: tuple[str, ...]
    kind: str = ""
    unit: str = ""

    def agrees(self, column: ColumnLook) -> bool:
        """Whether a guess is right."""
        unit = not self.unit or column.unit == self.unit
        return column.quantity in self.quantities and unit and (not self.kind or column.kind == self.kind)


def known(words: str) -> Known:
    """'angle or position, command, deg' as a truth; units are what is left."""
    first, *rest = [part.strip() for part in words.split(",")]
    kind = next((part for part in rest if part in ("command", "measured", "modelled")), "")
    unit = next((part for part in rest if part != kind), "")
    return Known(tuple(first.split(" or ")), kind, unit)


_TIME, _STILL = "time, s", "constant or angle or angular velocity"
_QUANSER_RUN = [
    *[_TIME, "current, command, A", "current, measured, A"] * 2,
    *[
        _TIME,
        "angle, command, deg",
        "angle, measured, deg",
        _TIME,
        "deflection, command",
        "deflection, measured, deg",
    ]
    * 2,
]
_STATE = ["angle, measured, rad", "position or deflection, measured", "angular velocity, measured, rad/s"]
_STATE += ["velocity or angular velocity, measured"]
_QUANSER_FULL = [
    *[_TIME, *_STATE],
    *[_TIME, "angle, command, rad", *["constant"] * 3],
    *[_TIME, "angle, command, rad", *["constant"] * 3],
    *[_TIME, *_STATE],
]
_QUANSER_STEP = [
    _TIME,
    "angle, measured, rad",
    "deflection, measured, rad",
    "angular velocity, measured, rad/s",
    "angular velocity, measured, rad/s",
    *["angle, command, rad", *["constant"] * 3],
    *["constant"] * 4,
    *_STATE,
    *["angle,,rad", "deflection,,rad", "angular velocity,,rad/s", "angular velocity,,rad/s"],
    *[_STILL] * 4,
]
_FAST_LIVE = [
    "time, s",
    "acceleration, m/s2",
    "angular velocity, command, rad/s",
    "angular velocity, command, rad/s",
]
_FAST_LIVE += ["angle,,rad", "angular velocity,,rad/s", "age, s", "flag", "flag"]
_FRAMES_LIVE = ["count", "time, s", "time, s", "image displacement,,px", "exposure,,s", "count", "count"]
_FRAMES_LIVE += ["image displacement,,px", "image rotation,,rad", *["variance"] * 4]
_FAST = [
    "time, s",
    "acceleration, m/s2",
    "angular velocity, command, rad/s",
    "angle,,rad",
    "angular velocity,,rad/s",
]
_FRAMES = ["count", "time, s", "time, s", "image displacement,,px", "time, s"]

TRUTH: dict[str, list[list[str]]] = {
    "silverbox/SNLS80mV.csv": [["input", "output"]],
    "robot_arm/robot_arm.dat": [["input", "output"]],
    "f16_vibration/f-16.txt": [[NOT_STATED] * 3],
    "quanser_flexible_link/lqr_full_10deg.mat": [_QUANSER_RUN, _QUANSER_FULL],
    "quanser_flexible_link/hinf_step_10deg_run01.mat": [_QUANSER_STEP],
    "quanser_flexible_link/lqg_step_neg_20deg_run01.mat": [_QUANSER_STEP],
    "phone_rotation/VID_20150409_162802.txt": [["time,,ms", "time,,ns", *["rotation matrix"] * 9]],
    "tuning_fork_video/tuning_hz32.txt": [["time", *["acceleration"] * 3, "temperature"]],
    "tuning_fork_video/raw_25_degrees.csv": [["time", "angular velocity", "angle", *["acceleration"] * 3]],
    "beam_video/data_synthetic_generated.npy": [["time", "image displacement,,px", "image displacement,,px"]],
    "live_demo/run_3/fast.csv": [_FAST_LIVE],
    "live_demo/run_3/frames.csv": [_FRAMES_LIVE],
    "live_demo/run_3/truth_deflection.csv": [["time, s", "deflection,,m"]],
    "live_demo/run_3/truth_frames.csv": [["count", "time, s"]],
    "strangers/case_01/fast.csv": [_FAST],
    "strangers/case_01/frames.csv": [_FRAMES],
    "strangers/delay_1/fast.csv": [_FAST],
    "strangers/delay_1/frames.csv": [_FRAMES],
}


@dataclass(frozen=True)
class Row:
    """One channel: what is known, what was guessed. right: None where nothing is known."""

    file: str
    column: str
    truth: str
    guess: str
    right: bool | None


def rows() -> Iterator[Row]:
    """Every channel of every file."""
    for name, tables in TRUTH.items():
        file = read_table_file(DATA / name)
        for table, truths in zip(file.tables, tables, strict=True):
            for column, truth in zip(look(table).columns, truths, strict=True):
                guess = ", ".join(filter(None, (column.quantity, column.kind, column.unit)))
                right = None if truth == NOT_STATED else known(truth).agrees(column)
                words = ", ".join(part.strip() for part in truth.split(",") if part.strip())
                yield Row(name, column.name, words, guess, right)


def table(found: list[Row]) -> str:
    """The table of docs/import.md, in Markdown: a row for each file, and each wrong channel by name."""
    lines = ["| file | channels | right | not right: truth, guess |", "|---|---|---|---|"]
    for name in TRUTH:
        judged = [row for row in found if row.file == name and row.right is not None]
        wrong = "; ".join(
            f"{row.column}: {row.truth}, guessed {row.guess}" for row in judged if not row.right
        )
        if not judged:
            wrong = "columns not stated by the source; " + ", ".join(r.guess for r in found if r.file == name)
        lines.append(f"| {name} | {len(judged)} | {sum(bool(r.right) for r in judged)} | {wrong} |")
    judged = [row for row in found if row.right is not None]
    right = sum(bool(row.right) for row in judged)
    lines += ["", f"{right} of {len(judged)} channels are right."]
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(list(rows())))
