"""A process that computes for as long as it is let: the load beside a run. Of ordinary priority, on any processor."""

import os


def main() -> None:
    """Run until terminated, or until whoever started it is gone."""
    parent, value = os.getppid(), 0
    while os.getppid() == parent:
        for step in range(100_000):
            value = (value * 1_103_515_245 + step) & 0xFFFFFFFF


if __name__ == "__main__":
    main()
