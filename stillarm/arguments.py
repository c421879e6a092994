"""Argument types that several commands use. Each refuses a wrong value in one line."""

import argparse
from math import isfinite, nan

LARGEST_SEED = 2**63 - 1


def seed(text: str) -> int:
    """A seed: a whole number from 0 to 2^63 - 1, which all generators and recording headers accept."""
    try:
        value = int(text)
    except ValueError:
        value = -1
    if not 0 <= value <= LARGEST_SEED:
        raise argparse.ArgumentTypeError(f"{text}: a whole number from 0 to {LARGEST_SEED} is needed")
    return value


def seconds(text: str) -> float:
    """A duration above zero, s."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not (isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"{text}: a number of seconds above 0 is needed")
    return value
