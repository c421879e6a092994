"""One finding as the report shows it: the fit before it and the fit with it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.report.residuals import residual_of
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.search.candidates import Candidate

ARM_CHANNELS = ("acceleration", "deflection", "displacement")


@dataclass(frozen=True)
class Case:
    """A finding (None: the whole, baseline against the end) with its fits and what was held out."""

    finding: Candidate | None
    before: Fit
    after: Fit
    split: Split

    @property
    def channels(self) -> list[str]:
        """All channels, the one that gained most (held out, in units of its noise) first."""
        return sorted(self.after.world.channels, key=lambda name: -self.gain(name))

    def gain(self, name: str) -> float:
        """Fall of the held-out residual's power, in units of the noise after."""
        data = make_data(self.before.world, self.split)
        mask = data.held[name] if data.held[name].any() else data.train[name]
        before, after = residual_of(self.before, name)[mask], residual_of(self.after, name)[mask]
        return float(np.sum(before**2) - np.sum(after**2)) / self.after.sigma[name] ** 2

    def first_of(self, *names: str) -> str | None:
        """The channel among these that gained most; None where none was measured."""
        return next((name for name in self.channels if name in names), None)


def cases(result: Result) -> Iterator[Case]:
    """Each finding against what came before it."""
    previous = result.found.baseline
    for one in result.found.findings:
        yield Case(one, previous, one.fit, result.split)
        if one.law is None:
            previous = one.fit


def whole(result: Result) -> Case:
    """The end against the baseline."""
    return Case(None, result.found.baseline, result.found.final, result.split)
