"""docs/recordings.md out of the matrix: `python -m tests.recordings.table` writes it."""

from pathlib import Path

from tests.recordings.expected import cells, refusal
from tests.recordings.outcome import COMMANDS
from tests.recordings.shapes import SHAPES

PAGE = Path(__file__).parents[2] / "docs" / "recordings.md"

_HEAD = """# Which recordings each command takes

Import any folder with a `fast.csv`, or one file with `--map`, and run any command on the result. Each ends in an
answer or in one line on standard error that says what is missing and what to do, with exit status 1 or 2:

    $ stillarm calibrate joint.mcap --model model.toml -o new.toml
    stillarm: joint.mcap: no channel shows the arm (acceleration, displacement or deflection); record one of them while
    the arm moves

The table shows every kind of recording that the tests make from seeds ([tests/recordings](../tests/recordings)), and
what each command says to it: "yes" is an answer, other words are those of the refusal, "-" has no recording to work
on. The tests fail where a cell differs, or where this page is not the one that `python -m tests.recordings.table`
writes.

- A channel with too few values, or an arm's channel that never changes, is left out of a diagnosis:
  `channels_left_out` in diagnosis.json says why.
- Rows need not come at the model's cycle: `diagnose` works at their own rate, from four rows a period of the first
  mode on.
- Where no command was recorded, the measured motion of the joint drives the simulation, and is not judged itself.
- Rows that come twice or out of order are put right. A clock that was set is a finding, not an error.
- Time may start anywhere, such as Unix epoch seconds.
- `diagnose --budget-s S` gives a verdict within S seconds (10 or more); `looked_at` in diagnosis.json says what was
  left out. A recording too long for the budget is diagnosed from its start as far as the time goes.

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
    total = f"{len(reached)} cells: {len(reached) - refused} end in an answer, {refused} in a refusal.\n"
    return _HEAD + "\n".join(lines) + "\n\n" + total


if __name__ == "__main__":
    PAGE.write_text(page())
    print(PAGE)
