"""Progress as lines, for whoever reads them from a pipe: each percent once."""

import pytest

from stillarm.progress import progress_bar


def test_lines_tell_each_percent_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("STILLARM_PROGRESS", "lines")
    with progress_bar("fit") as done:
        for share in (0.001, 0.42, 0.421, 1.0):
            done(share)
    assert capsys.readouterr().err == "progress 0.00 fit\nprogress 0.42 fit\nprogress 1.00 fit\n"


def test_nothing_is_written_to_a_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("STILLARM_PROGRESS", raising=False)
    with progress_bar("fit") as done:
        done(0.5)
    assert capsys.readouterr().err == ""
