"""One sequence of steps, spread over the controller's cycles: a step a cycle, so that none is long.

The sequence is a generator. It yields the name of its next step and does that step when it is resumed, so that
whoever interrupts it can see what is due.
"""

from collections.abc import Generator
from typing import TypeAlias

Steps: TypeAlias = Generator[str, bool, None]
NOTHING = ""


class SpreadWork:
    """Holds at most one sequence. due: name of its next step; NOTHING where none is left."""

    def __init__(self) -> None:
        """No sequence."""
        self._steps: Steps | None = None
        self.due = NOTHING

    def begin(self, steps: Steps) -> None:
        """Put a sequence in place of what is left of the one before. None of its steps has been done yet."""
        self._steps = steps
        self.due = next(steps, NOTHING)

    def advance(self) -> None:
        """Do the step that is due."""
        if self._steps is not None:
            self.due = next(self._steps, NOTHING)

    def advance_through(self, steps: frozenset[str]) -> None:
        """Do at once all that is due, as long as it is one of `steps`."""
        while self.due in steps:
            self.advance()

    def withdraw(self) -> None:
        """Tell the sequence, in place of its next step, that what it has prepared for it no longer holds."""
        if self._steps is not None:
            self.due = self._steps.send(True)
