"""The pictures hold every method and the bound."""

from pathlib import Path

from stillarm.benchmarks.estimators.figures import draw_errors_against_noise
from stillarm.benchmarks.estimators.tables import Job, estimator_rows, judge


def test_the_error_picture_holds_every_method_and_the_bound(tmp_path: Path) -> None:
    """A point for each row that has a number; a method without numbers is left out."""
    rows = [judge(Job("freerun constant", noise, 0, 0, ("timestamps",), 3.0)) for noise in (0.1, 1.0)]
    table = estimator_rows(rows)
    draw_errors_against_noise(table, "delay_rms_s", "bound_s", "rms delay error, s", tmp_path / "a.png")
    draw_errors_against_noise(
        [*table, *({**row, "method": "mute", "delay_rms_s": None} for row in table)],
        "delay_rms_s", "bound_s", "rms delay error, s", tmp_path / "b.png",
    )  # fmt: skip
    assert (tmp_path / "a.png").stat().st_size > 5000
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
