"""Every declaration says all there is to say, and says it in the form that its readers rely on."""

import inspect
from importlib import import_module

import pytest

from stillarm.common.causes import CAUSES, Cause, experiment_between
from stillarm.common.causes.declaration import Acts

GIVEN: dict[Acts, int] = {
    "force": 6, "friction": 6, "frequency": 3, "command": 1, "play": 0, "sensitivity": 1, "reading": 2, "impulse": 1,
    "image": 2, "period": 0, "delay": 1, "burst": 1, "loss": 1, "age": 1, "clock": 1,
}  # fmt: skip
PLACES: dict[str, set[Acts]] = {
    "arm": {"force", "friction", "frequency", "key"},
    "drive": {"force", "command", "play", "key"},
    "accelerometer": {"sensitivity", "reading", "impulse", "key"},
    "camera": {"image", "key"},
    "timing": {"period", "delay", "burst", "loss", "age", "clock"},
}
every_cause = pytest.mark.parametrize("cause", CAUSES.values(), ids=lambda cause: cause.identifier)


@every_cause
def test_a_file_declares_the_cause_of_its_name(cause: Cause) -> None:
    assert import_module(f"stillarm.common.causes.{cause.identifier}").CAUSE is cause


@every_cause
def test_a_law_takes_what_its_site_gives_and_then_its_own_numbers(cause: Cause) -> None:
    assert cause.acts in PLACES[cause.place]
    if cause.acts == "key":
        assert cause.law is None and cause.key.count(".") == 1
        return
    assert cause.law is not None and not cause.key
    names = list(inspect.signature(cause.law).parameters)
    assert names[GIVEN[cause.acts] :] == [one.name for one in cause.numbers]


@every_cause
def test_the_words_fit_into_the_sentences_that_take_them_up(cause: Cause) -> None:
    for words in (cause.name, cause.sees):
        assert words[0].islower() and not words.endswith("."), words
    for sentence in filter(None, (cause.note, cause.provoke)):
        assert sentence.endswith("."), sentence
    for other, experiment in cause.confused_with.items():
        assert other in CAUSES and cause.identifier not in CAUSES[other].confused_with
        assert experiment[0].islower() and not experiment.endswith(".")
        assert experiment_between(other, cause.identifier) == experiment


def test_an_effect_is_idle_where_its_size_is_nothing() -> None:
    assert CAUSES["payload_change"].is_idle(
        {"onset_s": 0.0, "frequency_ratio": 1.0, "higher_modes_share": 1.0}
    )
    assert not CAUSES["payload_change"].is_idle(
        {"onset_s": 0.0, "frequency_ratio": 1.1, "higher_modes_share": 0.0}
    )
    assert CAUSES["mains_hum"].is_idle({"frequency_hz": 50.0, "amplitude_m_s2": 0.0, "phase_rad": 0.0})


@every_cause
def test_a_complex_step_through_a_law_of_the_arm_is_its_derivative(cause: Cause) -> None:
    """f(x + i h) / h has the derivative as its imaginary part, to the last digits (Squire and Trapp, 1998)."""
    if cause.law is None or cause.acts not in ("force", "friction", "frequency"):
        return
    values = {one.name: one.default or (one.typical[0] if one.typical[0] else 2.0) for one in cause.numbers}
    state = (3.1, 0.3, 0.2, 0.01, -0.2, 16.0) if GIVEN[cause.acts] == 6 else (3.1, 0.0, 2.6)
    given = [*state, *cause.arguments(values)]
    for place in range(len(given)):
        if cause.acts == "frequency" and place == 1:  # the number of a mode
            continue
        step = 1e-4 * max(abs(given[place]), 1e-3)
        inside = [*given[:place], complex(given[place], 1e-30), *given[place + 1 :]]
        ends = [cause.law(*given[:place], given[place] + side, *given[place + 1 :]) for side in (step, -step)]
        by_difference = (ends[0] - ends[1]) / (2.0 * step)
        assert complex(cause.law(*inside)).imag / 1e-30 == pytest.approx(by_difference, rel=1e-4, abs=1e-12)
