"""How sure a finding is where something without a name is left beside it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from stillarm.diagnosis.anonymous import Explained
from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.fit import Data, Fit
from stillarm.diagnosis.laws import LawFound
from stillarm.diagnosis.scatter import ON_ITS_PAST
from stillarm.diagnosis.screen import Screening
from stillarm.diagnosis.split import interleaved
from stillarm.diagnosis.structure import Remains, Structure
from stillarm.diagnosis.verdict import Judged, _held_out, _lead_of_laws, judge, sure
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(9.0)


def left_in(channel: str, nats: float, train_log_likelihood: float) -> Structure:
    """Memory that no cause explains."""
    return Structure(channel, False, nats, 10.0, train_log_likelihood, (1.0, 30.0), ON_ITS_PAST, "")


def candidate(cause: str, nats: float, law: bool) -> Candidate:
    """A finding that every block bears out alike."""
    gains = np.where(SPLIT.held, nats / SPLIT.held.sum(), 0.0)
    found = LawFound(cause, {}, 2.0 * nats, gains) if law else None
    return Candidate(cause, LAST, 2.0 * nats, nats, 1.0, gains, {}, found)


@dataclass
class Later:
    """A result that is there already."""

    known: Remains

    def result(self) -> Remains:
        """It."""
        return self.known


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


@pytest.mark.slow
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


def test_a_term_is_a_rival_of_the_largest_finding_not_of_what_was_taken_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A clock that plainly stepped is taken before the damping that explains ten times as much, as a term does."""
    step, damping = (
        candidate(*one, law=False) for one in (("clock_step", 30.0), ("quadratic_damping", 300.0))
    )
    step = replace(step, values={"step_s": (0.0021, 1e-4)})
    gained = np.where(SPLIT.held, 290.0 / SPLIT.held.sum(), 0.0)
    terms = Explained(("force: speed times its size",), (0.1,), "acceleration", 500.0, 500.0, gained, gained)
    nothing = Explained((), (), "", 0.0, 0.0, *np.zeros((2, len(SPLIT.held))))
    left, white = (
        left_in("acceleration", 290.0, 500.0),
        replace(left_in("acceleration", 0.0, 0.0), white=True),
    )

    def verdict(*named: Candidate) -> str:
        seen = iter([Remains({"acceleration": white}, nothing), Remains({"acceleration": left}, terms)])
        monkeypatch.setattr("stillarm.diagnosis.verdict.meanwhile", lambda *_: Later(next(seen)))
        monkeypatch.setattr("stillarm.diagnosis.verdict.examine", lambda *_: next(seen))
        stages = [Stage(Screening([], 10.0), [one], one) for one in named]
        return judge(Found(LAST, LAST, list(named), stages), SPLIT).verdict

    assert verdict(step, damping) == "named"
    assert verdict(step) == "unexplained"


def test_what_is_said_of_held_out_errors_is_of_the_channel_that_is_mended_most_and_not_by_chance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Also where an image is finer than what the simulation may be off; not where a joint is off by next to nothing."""
    mended = replace(LAST, vector=LAST.vector.copy())
    errors = {
        "acceleration": (0.4981, 0.4977, 14_000),
        "displacement": (0.008, 0.001, 900),
        "joint_position": (5e-7, 1e-8, 14_000),
    }

    def error(fit: Fit, data: Data, name: str, judging: object) -> tuple[float, float, int]:
        before, after, count = errors.get(name, (1.0, 1.0, 900))
        return (after if fit is mended else before), 0.5, count

    monkeypatch.setattr("stillarm.diagnosis.verdict._error", error)
    said = _held_out(replace(candidate("drive_dead_time", 300.0, law=False), fit=mended), LAST, SPLIT)
    assert (said["nrmse_before"], said["nrmse_after"]) == (0.016, 0.002)
    assert said["reduction"] == 0.875
