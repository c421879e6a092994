"""How sure a finding is where something without a name is left beside it."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.anonymous import Explained
from diagnosis.candidate import Candidate, Found, Stage
from diagnosis.laws import LawFound
from diagnosis.scatter import ON_ITS_PAST
from diagnosis.screen import Screening
from diagnosis.split import interleaved
from diagnosis.structure import Remains, Structure
from diagnosis.verdict import Judged, _lead_of_laws, judge, sure
from tests.diagnosis.synthetic import fitted, measured

SPLIT = interleaved(9.0)


def left_in(channel: str, nats: float, train_nats: float) -> Structure:
    """Memory that no cause explains."""
    return Structure(channel, False, nats, 10.0, train_nats, (1.0, 30.0), ON_ITS_PAST, "")


def candidate(cause: str, nats: float, law: bool) -> Candidate:
    """A finding that every block bears out alike."""
    gains = np.where(SPLIT.held, nats / SPLIT.held.sum(), 0.0)
    found = LawFound(cause, {}, 2.0 * nats, gains) if law else None
    return Candidate(cause, LAST, 2.0 * nats, nats, 1.0, gains, {}, found)


LAST = fitted(measured(9.0, 3), split=SPLIT)


def test_a_law_of_noise_is_doubtful_where_the_mean_is_wrong() -> None:
    spikes = candidate("impulse_noise", 90.0, law=True)
    stage = Stage(Screening([], 10.0), [spikes], spikes)
    here = Judged("unexplained", {}, {}, left_in("acceleration", 40.0, 60.0), left_nats=40.0)
    elsewhere = Judged("unexplained", {}, {}, left_in("displacement", 40.0, 60.0), left_nats=40.0)
    assert sure(spikes, stage, here) < 0.5 < sure(spikes, stage, elsewhere)


def test_what_explained_more_than_the_finding_before_there_was_one_leads_it() -> None:
    named = candidate("payload_change", 150.0, law=False)
    nothing = Explained((), (), "", 0.0, 0.0, *np.zeros((2, len(SPLIT.held))))
    for nats, leads in ((180.0, True), (100.0, False)):
        first = Remains({"displacement": left_in("displacement", nats, 2.0 * nats)}, nothing)
        assert (_lead_of_laws(named, first) > 0.0) is leads


def test_a_term_without_a_name_that_does_as_well_is_a_rival() -> None:
    tilt = replace(
        candidate("camera_tilt_coupling", 50.0, law=False), values={"rotation_px_per_rad": (90.0, 3.0)}
    )
    tilt = replace(tilt, free=("camera.rotation_px_per_rad",))
    stage = Stage(Screening([], 10.0), [tilt], tilt)
    beaten, nearly = (Judged("named", {}, {}, None, named=share) for share in (1.0, 0.3))
    assert sure(tilt, stage, beaten) > 0.9
    assert sure(tilt, stage, nearly) == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize(
    ("channel", "verdict"), [("acceleration", "unexplained"), ("joint_position", "none")]
)
def test_a_cause_too_small_for_a_name_is_left_unexplained_but_for_an_encoders(
    channel: str, verdict: str
) -> None:
    small = candidate("joint_friction", 50.0, law=False)
    mended = LAST.residuals | {channel: 0.5 * LAST.residuals[channel]}
    small = replace(small, fit=replace(LAST, residuals=mended))
    stage = Stage(Screening([], 10.0), [], None, too_small=small)
    judged = judge(Found(LAST, LAST, [], [stage]), SPLIT)
    assert judged.verdict == verdict
    without = judge(Found(LAST, LAST, [], [replace(stage, too_small=None)]), SPLIT)
    assert without.verdict == "none"
