"""How the columns of a table hang together: copies, derivatives, leads."""

from dataclasses import dataclass, field

from stillarm.tables.guesses.copies import EXACT, Copy, copies
from stillarm.tables.guesses.derivative import Derivative, derivatives
from stillarm.tables.guesses.lead import Lead, leads
from stillarm.tables.guesses.spectra import Spectra, only


@dataclass(frozen=True)
class Relations:
    """Relations, by the column that repeats, derives or follows another. near: copies but for some per cent."""

    copies: dict[str, Copy] = field(default_factory=dict)
    near: dict[str, Copy] = field(default_factory=dict)
    derivatives: dict[str, Derivative] = field(default_factory=dict)
    leads: dict[str, Lead] = field(default_factory=dict)


def relations_of(held: Spectra, rate_hz: float | None) -> Relations:
    """Every relation that is sure. Exact copies take no part in the others."""
    found = copies(held)
    exact = {copy.column: copy for copy in found if copy.rest < EXACT}
    alone = only(held, set(held.samples) - set(exact))
    return Relations(
        exact,
        {copy.column: copy for copy in found if copy.rest >= EXACT},
        {derivative.column: derivative for derivative in derivatives(alone, rate_hz)},
        {lead.follower: lead for lead in leads(alone)},
    )
