"""Which forms a round goes on with. What a round takes in the end: tests/diagnosis/decision/test_explain.py."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search import comparison
from stillarm.diagnosis.search.begun import Begun, Pair
from stillarm.diagnosis.search.candidates import Candidate, Found, Hint, Stage
from stillarm.diagnosis.search.comparison import best_of_each
from stillarm.diagnosis.search.refits import FROM_AFAR, LOOK


def begun(cause: str, name: str = "", added: bool = False) -> Begun:
    """Where a form of a cause begins."""
    form = SimpleNamespace(id=cause, name=name, added=added or None, cause=SimpleNamespace(settle={}))
    return cast(Begun, SimpleNamespace(form=form, asked=False))


def kept(*quick: tuple[Begun, float, float]) -> list[str]:
    """The causes that go on, of quick fits with these gains and nats."""
    tried: list[tuple[Any, Fit]] = [
        (comparison._Promise(*one), cast(Fit, SimpleNamespace())) for one in quick
    ]
    return sorted(one.form.id for one, _ in best_of_each(tried))


@pytest.mark.parametrize(
    ("nats", "goes_on"),
    [(300.0, True), (90.0, False)],  # of the most, 1000: a tenth is asked
)
def test_a_form_goes_on_by_either_measure(nats: float, goes_on: bool) -> None:
    """A loud line gains most by white noise's likelihood, and nothing by the other."""
    hum = (begun("mains_hum"), 29000.0, -40.0)
    lens = (begun("lens_distortion"), 1000.0, 1000.0)
    tilt = (begun("camera_tilt_coupling"), 270.0, nats)
    assert ("camera_tilt_coupling" in kept(hum, lens, tilt)) is goes_on
    assert {"mains_hum", "lens_distortion"} <= set(kept(hum, lens, tilt))


def test_what_gains_nothing_goes_on_only_as_a_course() -> None:
    hum = (begun("mains_hum"), 29000.0, -40.0)
    assert kept(hum, (begun("drive_lag"), 3.0, 2.0)) == ["mains_hum"]
    assert kept(hum, (begun("tracking_drift", "along a course", True), 3.0, 2.0)) == [
        "mains_hum",
        "tracking_drift",
    ]


def test_beside_a_free_form_the_declared_one_is_polished_too() -> None:
    """Not that of a cause whose best form is a formula already, nor one that is worth nothing."""
    merits = {
        ("camera_tilt_coupling", "along an arc", True): 700.0,
        ("camera_tilt_coupling", "", False): 250.0,
        ("drive_lag", "a further lag", False): 90.0,
        ("drive_lag", "", False): 80.0,
        ("tracking_drift", "along a course", True): 60.0,
        ("tracking_drift", "", False): -5.0,
    }
    pairs: list[Pair] = [(begun(*key), cast(Fit, SimpleNamespace(key=key))) for key in merits]
    candidates = [
        Candidate(key[0], pair[1], 0.0, 0.0, {}, form=key[1], merit=merit)
        for (key, merit), pair in zip(merits.items(), pairs, strict=True)
    ]
    leading = [(one.form.id, one.form.name) for one, _ in comparison._leading(pairs, candidates)]
    assert leading == [
        ("camera_tilt_coupling", "along an arc"),
        ("drive_lag", "a further lag"),
        ("tracking_drift", "along a course"),
        ("camera_tilt_coupling", ""),
    ]


@pytest.mark.parametrize(
    ("struck", "merit", "matters", "near"),
    [
        (True, 900.0, True, True),
        (True, 300.0, True, False),  # of 1000 where it was found
        (False, 900.0, True, False),
        (False, 300.0, False, True),
    ],
)
def test_a_hint_says_which_forms_are_near(
    monkeypatch: pytest.MonkeyPatch, struck: bool, merit: float, matters: bool, near: bool
) -> None:
    """Where it tells all here, or as much as there beside more impacts alone."""
    monkeypatch.setattr(comparison, "anything_but_spikes_matters", lambda fit, split: matters)
    there, here = (
        Candidate("gravity_leakage", cast(Fit, None), 0.0, 0.0, {}, merit=one) for one in (1000.0, merit)
    )
    hint = Hint(cast(Fit, None), Stage([], [there], there), struck)
    assert comparison._says_which_are_near(hint, here, interleaved(10.0)) is near


def test_of_several_starts_afar_the_best_two_go_on_from_where_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of the form that begins in two places, and of what begins near, each start is fitted at once."""
    payload, stiffness, hum = (cast(Form, SimpleNamespace(id=name, name="")) for name in ("p", "s", "h"))
    world = cast(World, SimpleNamespace(forget=lambda: None))
    starts = [
        (payload, 4.0),
        (payload, 1.0),
        (payload, 3.0),
        (payload, 2.0),
        (stiffness, 5.0),
        (stiffness, 6.0),
    ]
    begun_at = [Begun(form, world, np.array([at])) for form, at in (*starts, (hum, 7.0))]
    fitted_from: list[tuple[float, int]] = []

    def quickly(ground: object, one: Begun, steps: int = FROM_AFAR) -> tuple[comparison._Promise, Fit]:
        at = float(one.start[0])
        fitted_from.append((at, steps))
        shown = SimpleNamespace(forget=lambda: None)
        end = cast(Fit, SimpleNamespace(vector=np.array([at - 0.5]), predicted=shown))
        return comparison._Promise(one, -at, 0.0), end

    monkeypatch.setattr(comparison, "_quickly", quickly)
    monkeypatch.setattr(comparison, "begins_afar", lambda ground, one: one.form is not hum)
    monkeypatch.setattr(
        comparison, "shared_out", lambda work, items, known=(): [work(item) for item in items]
    )
    found = Found(cast(Fit, None), cast(Fit, None))
    quick = comparison._quick_fits(cast(Any, None), begun_at, found, [])
    looks = [(at, LOOK) for at in (4.0, 1.0, 3.0, 2.0)]
    whole = [(at, FROM_AFAR) for at in (5.0, 6.0, 7.0, 0.5, 1.5)]
    assert fitted_from == [*looks, *whole]
    assert [one.begun.form for one, _ in quick[7:]] == [payload, payload]


def test_a_fit_comes_back_without_its_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred of a minute would take a gigabyte."""
    forgot: list[int] = []
    monkeypatch.setattr(
        comparison, "shared_out", lambda work, items, known=(): [work(item) for item in items]
    )

    def work(item: int) -> tuple[int, Fit | None]:
        shown = SimpleNamespace(forget=lambda: forgot.append(item))
        return item, cast(Fit, SimpleNamespace(predicted=shown)) if item else None

    found = Found(cast(Fit, None), cast(Fit, None))
    assert [key for key, _ in comparison._each(work, [0, 1, 2], found, [])] == [1, 2]
    assert forgot == [1, 2]
