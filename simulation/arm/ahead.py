"""Makes an arm ready before any clock runs: compiled once after an installation, later loaded from disk.

Compiling takes about ten seconds of a processor, loading a quarter of one. Beside running daemons either would cost
images and cycles; a caller that is about to start them calls this first.
"""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

from stillarm.common.files.model import Model

if TYPE_CHECKING:
    from stillarm.simulation.arm.plant import Plant

_COMPILING = "compiling the simulated arm, once after an installation"
_LOADED_WITHIN_S = 2.0  # longer than a load from disk takes


def ready_plant(model: Model, name: str = "model") -> "Plant":
    """A plant, when all that it calls is compiled or loaded; says so on standard error where that takes long.

    `name` stands for the model's file in messages. Raises UserError for a model that cannot be simulated.
    """
    with told_if_slow(_COMPILING, sys.stderr):
        # not above: the compiler's import is part of the time
        from stillarm.simulation.arm.plant import Plant

        return Plant(model, name)


@contextmanager
def told_if_slow(what: str, to: TextIO, within_s: float = _LOADED_WITHIN_S) -> Iterator[None]:
    """Write the line "WHAT: 8 s" where the body takes longer than `within_s`; its first half as soon as it does."""
    started, told = time.monotonic(), threading.Event()

    def tell() -> None:
        told.set()
        print(f"{what}: ", end="", file=to, flush=True)

    timer = threading.Timer(within_s, tell)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
        if told.is_set():
            print(f"{time.monotonic() - started:.0f} s", file=to, flush=True)
