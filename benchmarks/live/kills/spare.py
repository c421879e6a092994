"""A supervisor that waits: its modules are loaded, so that it takes a killed one's place in a tenth of a second.

It is started while the other one still works, says `ready`, and begins when it reads a line.
"""

import sys
from pathlib import Path

from stillarm.supervisor.daemon import run


def main(configuration: str) -> int:
    """Wait for a line, then be the supervisor; end where the pipe ends instead."""
    print("ready", flush=True)
    if sys.stdin.readline():
        run(Path(configuration))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
