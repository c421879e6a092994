"""The first table: paired comparisons and standard errors."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.benchmarks.estimators.tables import Job, Judged, comparison_rows, estimator_rows
from stillarm.benchmarks.estimators.trial import Score


def made_up(ours: list[float], other: list[float]) -> list[Judged]:
    """Trials in which two methods had these mean errors."""

    def said(error: float) -> Score:
        return Score(error, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)

    job = Job("freerun drift", 0.3, 0, 0, ("fused", "timestamps"))
    return [
        Judged(job, {"fused": said(a), "timestamps": said(b)}, {}, 1e-4, 1e-4, 1e-3)
        for a, b in zip(ours, other, strict=True)
    ]


def test_comparisons_are_paired() -> None:
    """A difference that every trial shows counts, however much the trials vary; other differences do not."""
    level = [0.01, 0.05, 0.2, 0.4]
    rows = comparison_rows(made_up([x + 0.001 * (1 + 0.1 * k) for k, x in enumerate(level)], level))
    worse = {row["figure"]: row["worse"] for row in rows}
    assert worse == {"error_mean": True, "error_max": False, "delay_rms_s": False}
    undecided = comparison_rows(made_up([0.02, 0.01, 0.03, 0.01], [0.01, 0.02, 0.01, 0.02]))
    assert not any(row["worse"] for row in undecided)
    assert comparison_rows(made_up([0.02], [0.01]))[0]["standard_error"] is None
    assert estimator_rows(made_up([0.02, 0.04], [0.01, 0.01]))[0]["error_mean"] == pytest.approx(0.03)


def test_standard_errors_are_those_of_means() -> None:
    """For means the usual formula; for the delay's ratio the spread between campaigns of as many trials."""
    errors = [0.02, 0.05, 0.03, 0.02]
    row = estimator_rows(made_up(errors, errors))[0]
    assert row["standard_errors"]["error_mean"] == pytest.approx(np.std(errors, ddof=1) / 2.0)
    assert set(estimator_rows(made_up([0.02], [0.01]))[0]["standard_errors"].values()) == {None}
    random, trials = np.random.default_rng(5), made_up([0.01] * 20, [0.01] * 20)
    ratios, stated = [], []
    for _ in range(200):
        delays = 1e-4 * np.abs(random.standard_normal(20))
        cell = [
            replace(one, scores={"fused": replace(one.scores["fused"], delay_rms_s=float(delay))})
            for one, delay in zip(trials, delays, strict=True)
        ]
        row = estimator_rows(cell)[0]
        ratios.append(row["ratio"])
        stated.append(row["standard_errors"]["ratio"])
    assert np.mean(stated) == pytest.approx(np.std(ratios), rel=0.15)
