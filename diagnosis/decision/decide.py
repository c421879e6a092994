"""From what was found to what is said: named, none or unexplained, how sure, and what is left (contract.md)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from math import inf, tanh

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.data.channels import JOINT_CHANNELS
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.free_terms import beside_the_others, best_free
from stillarm.diagnosis.decision.rival_causes import (
    ODDS_NATS,
    beside_what_followed,
    changes_structure,
    class_of,
    runner_up,
)
from stillarm.diagnosis.decision.rival_laws import rival_law
from stillarm.diagnosis.fitting.evidence import score
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.rest import (
    Rest,
    anything_matters,
    explainable,
    rest_of,
    times_what_matters,
)
from stillarm.diagnosis.forms.freeform import Free, Group
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.search.candidates import (
    EXPLAINED,
    Candidate,
    Found,
    shows_most,
    turns_the_joint,
)
from stillarm.diagnosis.search.convincing import is_course, is_of_free_form, rings_with_a_mode

MOST_CONFIDENCE = 0.9
"""However large the odds: of 59 names that the odds alone put above 0.9 in recordings of another simulator, 54 were
right (docs/benchmark-diagnosis.md; rule of succession). A cause that is in no catalogue may look like one that is,
whatever the odds against the others."""
_THIRD = 0.22
"""The most that a third finding is sure: of seven beside two others, in recordings of another simulator, one was right
(seeds 417 to 423: docs/benchmark-diagnosis.md; rule of succession). What two formulas leave that are not quite the true
ones looks like a further cause."""
_SURE = 2  # findings, beyond which that holds
_UNCOMPARED = 0.7
"""The most that a name is sure where the time did not suffice to hold free terms against it: of ten such names seven
were right (seeds 120 and 122, and the strangers': docs/benchmark-diagnosis.md; rule of succession)."""
_TOLD_UNCOMPARED = 0.75
"""Of what is explainable, that such a name has to explain: less leaves as much to a law without a name as the name
itself has beyond what suffices (EXPLAINED)."""
_CHANNEL_OF = {"accelerometer": "acceleration", "camera": "displacement"}
_SHARPNESS = 10.0  # of the change from one verdict to the other
_OF_LAWS = 0.97  # a law of noise or timing is seen in its own channel
_FOLLOWER_LEAVES = 0.3
"""Of what matters in the channel that it follows, as an rms, the most that a course over time leaves: one that goes
where it will, and yet leaves more, follows something else. Knots leave a tenth of a random walk, and less of a jump.
The same of a force at the frequency of a mode: whatever moves the arm, most of that lies there."""
_RIVAL = 0.05  # of a finding's nats: free terms are no better by less, as no formula is quite the true one


@dataclass(frozen=True)
class Judged:
    """The verdict. beside: the best free terms on top of all findings; alone: on top of the baseline."""

    verdict: str
    rests: list[Rest]
    beside: Free | None
    alone: Free | None
    confidence: dict[str, float] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()

    @property
    def left(self) -> Rest | None:
        """The largest rest that matters, by its noise."""
        material = [one for one in self.rests if not one.immaterial]
        return max(material, key=lambda one: one.share_of_noise, default=None)


def judge(found: Found, split: Split) -> Judged:
    """Weigh what was named against what has no name, and against nothing. found: its rivals get the merits that they
    have beside all that was found."""
    rests = [rest_of(found.final, name, split) for name in found.final.residuals]
    material = any(not one.immaterial for one in rests)
    mattered = anything_matters(found.baseline, split)
    first = found.findings[0] if found.findings else None
    left_out: list[str] = []
    beside = alone = None
    try:
        rivals = first is not None and _may_rival(first, found.final, split)
        # a course of free form leaves nothing, whatever it is that it follows
        if first is not None and (rivals or is_of_free_form(first, found.baseline)):
            alone = rival_law(first, fit_before(found, first), split)
        if alone is None:  # else there is no name that free terms could be held against
            own = shows_most(first) if first is not None else ()
            if material or rivals:
                beside = best_free(found.final, split, own)
            # whatever a perfect model would gain: where nothing matters, it is not told how much that is
            if first is not None and first.law is None:
                alone = _alone(found, first, own, (beside.group,) if beside else (), split)
    except OutOfTime:
        left_out.append("structure without a name")
    beside_what_followed(found, split)
    if first is None:
        verdict = "unexplained" if material else "none"
        return Judged(verdict, rests, beside, alone, {}, tuple(left_out))
    named = _odds_of_name(found, first, split, beside, alone, compared=not left_out)
    unnamed = "unexplained" if mattered or material else "none"
    verdict = "named" if named > 0.5 and len(class_of(found, first)) <= 1 else unnamed
    confidence = {
        one.cause: _confidence(found, one, named if one is first else _odds_beside(found, one, split))
        for one in found.findings
    }
    return Judged(verdict, rests, beside, alone, confidence, tuple(left_out))


def _alone(
    found: Found, first: Candidate, own: Sequence[str], others: Sequence[Group], split: Split
) -> Free | None:
    """The best free terms in the place of the first finding: by themselves on the fit that it was taken on, or where
    these lead and more was found, beside that. Where they tell as much as all findings together, they take the place of
    all: a sensor that bends in one way is then told by two causes, each of which bends in another."""
    best = best_free(fit_before(found, first), split, own, others)
    further = [one for one in found.findings if one is not first and one.law is None]
    if (
        best is None
        or not further
        or best.merit < first.merit
        or changes_structure(first.fit, found.baseline)
    ):
        return best
    lead = best.merit - sum(one.merit for one in (first, *further))
    if lead >= 0.0:
        return replace(best, merit=first.merit + lead, of_all=True)
    return beside_the_others(best, first, further, found.final, split)


def _odds_of_name(
    found: Found,
    first: Candidate,
    split: Split,
    beside: Free | None,
    alone: Free | None,
    compared: bool = True,
) -> float:
    """Probability that the first finding is what it is called, rather than a part of something without a name.
    compared: whether free terms were held against it."""
    if first.law is not None:
        return _OF_LAWS
    share = share_explained(first, fit_before(found, first), split, final=found.final)
    beyond = beside.merit if beside is not None and len(found.findings) == 1 else 0.0
    free = first.merit / max(first.merit + max(beyond, 0.0), 1e-9)
    ahead = (first.merit - (alone.merit if alone is not None else 0.0)) / max(first.merit, 1.0)
    # one law in the place of several names, and what bends as it will, are no formula that is not quite the true one
    exact = (alone is not None and alone.of_all) or is_of_free_form(first, fit_before(found, first))
    doubts = (
        _SHARPNESS * (share - EXPLAINED),
        _SHARPNESS * (free - 0.5),
        2.0 * _SHARPNESS * (ahead + (0.0 if exact else _RIVAL)),
    )
    odds = _logistic(min((*doubts, _doubt_of_follower(found, first, split))))
    if compared:
        return odds
    return min(odds, _UNCOMPARED if share > _TOLD_UNCOMPARED else 1.0 - _UNCOMPARED)


def _doubt_of_follower(found: Found, first: Candidate, split: Split) -> float:
    """Log odds of a course over time, or of a force at a mode's frequency, by what all findings leave in the channel
    that it follows; no doubt of any other finding, and where what is left does not matter."""
    if not (is_course(first, found.baseline) or rings_with_a_mode(first)):
        return inf
    (channel,) = shows_most(first)
    left = times_what_matters(found.final, channel, split)
    if left < 1.0:
        return inf
    before = times_what_matters(found.baseline, channel, split)
    return 2.0 * _SHARPNESS * (_FOLLOWER_LEAVES - left / max(before, 1e-9))


def _odds_beside(found: Found, one: Candidate, split: Split) -> float:
    """The same of a finding beside the first, of what that left."""
    if one.law is not None:
        return _OF_LAWS
    share = share_explained(one, fit_before(found, one), split, final=found.final, beside=True)
    return _logistic(_SHARPNESS * (share - EXPLAINED))


def _logistic(log_odds: float) -> float:
    return 0.5 * (1.0 + tanh(0.5 * log_odds))  # 1 / (1 + exp(-x)), which overflows below -709


def share_explained(
    one: Candidate, before: Fit, split: Split, final: Fit | None = None, beside: bool = False
) -> float:
    """What a finding gains, of the nats that a perfect model would gain where it was taken. 1 for a law: it is judged
    by its own channel. before: the fit that it was taken on; final: of all findings, what
    other ones explain being none of what it lacks. beside: one that tells of the largest departure.

    What goes wrong in a sensor or a drive shows in its own channels alone, and is judged there, if nothing larger is
    left elsewhere, or that has its name already; a finding of timing by all channels, or by the images' beside another;
    any other by all but the arrivals.
    """
    if one.law is not None:
        return 1.0
    gains = score(one.fit, split).gains(score(before, split))
    left = _left_to_explain(final or one.fit, before, gains, split)
    own = _own_channels(one, before, beside)
    if own and (beside or _largest_there(before, final or one.fit, own, split)):
        gained = sum(gains[name] for name in own)
        return max(gained, 0.0) / max(gained + sum(left[name] for name in own), 1e-9)
    gained = float(one.nats.sum())
    if _place(one) != "timing":
        left.pop("arrival", None)
    return gained / max(gained + sum(left.values()), 1e-9)


def _left_to_explain(after: Fit, before: Fit, gains: Mapping[str, float], split: Split) -> dict[str, float]:
    """Nats that a finding leaves to a perfect model, by channel. Nats make much of a quiet rest that lasts, beside a
    slow or short departure that was many times as large. So where what is left does not matter (contract.md), it is no
    larger a part of what the finding gained than its rms is of the rms that is gone."""
    left = explainable(after, split)
    for name, nats in left.items():
        now, then = (rest_of(one, name, split) for one in (after, before))
        if now.immaterial and then.rms > now.rms and gains[name] > 0.0:
            left[name] = min(nats, gains[name] * now.rms / (then.rms - now.rms))
    return left


def _own_channels(one: Candidate, before: Fit, beside: bool) -> tuple[str, ...]:
    """The measured channels in which alone a finding shows: its sensor's; the joint's, where the arm is moved by the
    joint as it was measured, whatever moved that; the images', of one of timing beside another."""
    if beside and _place(one) == "timing":
        return tuple(name for name in ("displacement", "arrival") if name in before.residuals)
    if turns_the_joint(one.cause) and before.world.joint_hz > 0.0:
        return tuple(name for name in JOINT_CHANNELS if name in before.residuals)
    own = _CHANNEL_OF.get(_place(one))
    return (own,) if own in before.residuals else ()


def _largest_there(before: Fit, after: Fit, own: tuple[str, ...], split: Split) -> bool:
    """Whether a finding's own channels departed from the model by more than any other still does, each by what matters
    in it."""
    others = [name for name in after.residuals if name not in (*own, "arrival")]
    left = max((times_what_matters(after, name, split) for name in others), default=0.0)
    return max(times_what_matters(before, name, split) for name in own) >= left


def fit_before(found: Found, one: Candidate) -> Fit:
    """The fit on which a finding was taken."""
    taken = [stage.taken for stage in found.stages if stage.taken is not None]
    fits = [each.fit for each in takewhile(lambda each: each is not one, taken) if each.law is None]
    return fits[-1] if fits else found.baseline


def _may_rival(first: Candidate, final: Fit, split: Split) -> bool:
    """Whether what the findings leave is worth enough for free terms to be told of beside the first."""
    return sum(explainable(final, split).values()) > _RIVAL * first.merit


def _place(one: Candidate) -> str:
    return DECLARED[one.cause].place


def _confidence(found: Found, one: Candidate, named: float) -> float:
    near = class_of(found, one)
    rival = runner_up(found, one)
    lead = one.merit - (rival.merit if rival is not None else 0.0)
    sure = _logistic(min(lead, 60.0) / ODDS_NATS)
    most = MOST_CONFIDENCE if found.findings.index(one) < _SURE else _THIRD
    return float(min(most, named * sure) / (1 + len(near)))
