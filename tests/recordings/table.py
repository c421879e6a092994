"""docs/recordings.md out of the matrix: `python -m tests.recordings.table` writes it."""

from pathlib import Path

from tests.recordings.expected import cells, refusal
from tests.recordings.outcome import COMMANDS
from tests.recordings.shapes import SHAPES

PAGE = Path(__file__).parents[2] / "docs" / "recordings.md"

_HEAD = """# Which recordings each command takes

Import any folder with a `fast.csv`, or one file with `--map`, and run any command on the result. Each command gives an
answer, or exits with status 1 or 2 and one line on standard error that says what is missing and what to do:

    $ stillarm calibrate joint.mcap --model model.toml -o new.toml
    stillarm: joint.mcap: no channel shows the arm (acceleration, displacement or deflection); record one of them while
    the arm moves

The table lists every kind of recording that the tests generate from seeds ([tests/recordings](../tests/recordings)),
and the response of each command. "yes" is an answer; other words quote the refusal; "-" means that there is no
recording to work on. The tests fail if a cell differs, or if this page differs from the output of
`python -m tests.recordings.table`.

- The diagnosis leaves out a channel that has too few values, and an arm's channel that never changes.
  `channels_left_out` in diagnosis.json says why.
- Rows need not have the model's cycle. `diagnose` works at the rate of the rows, from four rows a period of the first
  mode upwards.
- Without a recorded command, the measured motion of the joint drives the simulation, and is not judged itself.
- Duplicate and unordered rows are corrected. A clock that was set is a finding, not an error.
- Time may start anywhere, for instance at Unix epoch seconds.
- `diagnose --budget-s S` gives a verdict within S seconds (10 or more); `looked_at` in diagnosis.json says what was
  left out. If a recording is too long for the budget, `diagnose` uses as much of its beginning as the time allows.

"""


def page() -> str:
    """The page's text."""
    reached = set(cells())
    lines = [f"| recording | {' | '.join(COMMANDS)} |", f"|---|{'---|' * len(COMMANDS)}"]
    for shape in SHAPES:
        row = [
            (refusal(shape, command) or "yes") if (shape, command) in reached else "-" for command in COMMANDS
        ]
        lines.append(f"| {shape} | {' | '.join(row)} |")
    refused = sum(refusal(*cell) is not None for cell in reached)
    total = f"{len(reached)} cells: {len(reached) - refused} give an answer, {refused} a refusal.\n"
    return _HEAD + "\n".join(lines) + "\n\n" + total


if __name__ == "__main__":
    PAGE.write_text(page())
    print(PAGE)
