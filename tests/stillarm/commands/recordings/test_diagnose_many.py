"""Several recordings side by side: on threads here, on Dask where it is installed; one that is bad stops no other."""

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest

from stillarm.commands.recordings import diagnose_many
from stillarm.commands.recordings.diagnose_many import Job, diagnose_all, diagnose_one, executor_for
from stillarm.commands.recordings.diagnose_result import sentence
from stillarm.common.files.scenario import Move, Scenario, Strike
from stillarm.common.user_error import UserError
from stillarm.main import main
from tests.fixtures.simulated import record

SHORT = Scenario(
    duration_s=8.0, strikes=[Strike(0.6, 0.02)], moves=[Move(3.5, 4.3, 0.25), Move(4.6, 5.6, -0.2)]
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nothing wrong with it; short, for it is not the diagnosis that is judged here."""
    return record(tmp_path_factory.mktemp("many"), scenario=SHORT)


@contextmanager
def threads(scheduler: str | None, jobs: int) -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(2) as pool:
        yield pool


@pytest.mark.slow
def test_each_has_its_folder_and_a_bad_one_stops_no_other(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(diagnose_many, "executor_for", threads)
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"no recording")
    out = tmp_path / "out"
    assert main(["diagnose", str(bad), str(recording), "--no-use", "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert [line for line in said.err.splitlines() if "bad.mcap" in line]
    assert "nothing wrong" in said.out
    assert json.loads((out / "recording" / "diagnosis.json").read_text())["verdict"] == "none"
    assert not (out / "bad").exists()


def test_a_scheduler_that_does_not_answer_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(diagnose_many, "_CONNECT_S", 1)
    with (
        pytest.raises(UserError, match="no Dask scheduler answers there"),
        executor_for("tcp://127.0.0.1:9", 2),
    ):
        pass


@pytest.mark.slow
def test_dask_s_workers_diagnose_as_this_process_does(recording: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    job = Job(recording, tmp_path / "out", None, (), use_pairs=0)
    with (
        distributed.LocalCluster(1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        executor_for(cluster.scheduler_address, 1) as executor,
    ):
        (done,) = diagnose_all([job], executor)
    assert not done.failed and "nothing wrong" in done.said
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.slow
def test_a_bad_one_by_itself_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"no recording")
    out = tmp_path / "out"
    assert main(["diagnose", str(bad), "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert said.err.startswith(f"stillarm: {bad}") and len(said.err.splitlines()) == 1
    assert not said.out and not out.exists()


@pytest.mark.slow
def test_progress_never_falls_and_leaves_a_share_for_the_use(recording: Path, tmp_path: Path) -> None:
    shares: list[float] = []
    done = diagnose_one(Job(recording, tmp_path / "out", None, (), use_pairs=0), shares.append)
    assert not done.failed
    assert shares == sorted(shares) and 0.8 < shares[-1] <= 0.9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("left_out", "says"),
    [
        ([], ""),
        (["use"], ""),
        (["use", "pairs of causes"], "did not suffice for pairs of causes: give it more with"),
    ],
)
def test_a_verdict_says_what_there_was_no_time_for(left_out: list[str], says: str) -> None:
    """What the extended model is worth is no part of the verdict."""
    table = {"findings": [], "events": [], "verdict": "none", "looked_at": {"left_out": left_out}}
    said = sentence(table)
    assert said.startswith("nothing wrong") and says in said and ("time" in said) == bool(says)


def test_a_verdict_says_what_of_the_recording_could_not_be_read() -> None:
    looked_at = {"left_out": [], "incomplete": "its end is missing"}
    table = {"findings": [], "events": [], "verdict": "none", "looked_at": looked_at}
    said = sentence(table)
    assert said.startswith("nothing wrong") and "incomplete: its end is missing" in said
    assert "incomplete" not in sentence(table | {"looked_at": looked_at | {"incomplete": ""}})
