"""Which cells of the matrix are refused, and by what words: all others end in an answer (docs/recordings.md)."""

from tests.recordings.outcome import COMMANDS
from tests.recordings.shapes import SHAPES

NO_ARM, NO_LENGTH, NOTHING = "no channel shows the arm", "arm.length_m: needed", "no measured channel"
SHORT, PAIR, NO_CYCLES = "too short", "a pair of input and output", "holds no cycles"

_NO_IMPORT = {
    "frames.csv alone": "fast.csv: not there",
    "no rows": "no rows",
    "pair of unknown rate": "--rate-hz: needed with --map",
    "pair, no such column": "no such column",
}
_NO_CALIBRATION = {
    "joint": NO_ARM,
    "joint without a command": NO_ARM,
    "joint position alone": NO_ARM,
    "joint velocity alone": NO_ARM,
    "command alone": NO_ARM,
    "joint and torque": NO_ARM,
    "torque alone": NO_ARM,
    "strain of unknown scale": NO_ARM,
    "joint, no model": NO_ARM,
    "time alone": NO_ARM,
    "one sample": SHORT,
    "two samples": SHORT,
    "sixty samples": SHORT,
    "one frame": NO_ARM,
    "accelerometer alone, constant": NO_ARM,
    "images constant": NO_ARM,
    "deflection constant": NO_ARM,
    "nothing moves": NO_ARM,
    "accelerometer all NaN": NO_ARM,
    "pair": PAIR,
    "pair of eight samples": PAIR,
    "pair, constant input": "the input never changes",
    "pair, constant output": PAIR,
    "pair, NaN": PAIR,
    "pair, input all NaN": "the input never changes",
}
_NO_DIAGNOSIS = {
    "joint without a command": NOTHING,
    "joint position alone": NOTHING,
    "joint velocity alone": NOTHING,
    "command alone": NOTHING,
    "torque alone": NOTHING,
    "strain of unknown scale": NOTHING,
    "time alone": NOTHING,
    "one sample": SHORT,
    "two samples": SHORT,
    "sixty samples": SHORT,
    "accelerometer alone, constant": NOTHING,
    "pair of eight samples": "samples are too few",
    "pair, constant input": "the input never changes",
    "pair, constant output": "the output cannot be diagnosed",
    "pair, input all NaN": "the input never changes",
}
_NO_REPLAY = {name: NO_LENGTH for name in SHAPES if name.endswith("no model")} | {
    name: NO_CYCLES for name, shape in SHAPES.items() if shape.arguments
}
REFUSED = {
    "import": _NO_IMPORT,
    "replay": _NO_REPLAY,
    "calibrate": _NO_CALIBRATION,
    "diagnose": _NO_DIAGNOSIS,
}


def refusal(shape: str, command: str) -> str | None:
    """The words of a cell's refusal; None where it ends in an answer."""
    return REFUSED.get(command, {}).get(shape)


def cells() -> list[tuple[str, str]]:
    """Shape and command of every cell that is reached: without a recording there is only the import."""
    return [
        (shape, command)
        for shape in SHAPES
        for command in COMMANDS
        if command == "import" or refusal(shape, "import") is None
    ]
