"""`stillarm replay REC --method all`, then its tables as columns: `python -m ... REC DIR`, a process of its own."""

import sys
from pathlib import Path

from stillarm.main import main as stillarm
from stillarm.panel.recordings.replayed import convert


def main(path: str, folder: str) -> int:
    """Run; returns the exit status."""
    status = stillarm(["replay", path, "--method", "all", "--out", folder])
    if status == 0:
        convert(Path(folder))
    return status


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
