"""`stillarm track`, as a user types it."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.main import main
from tests.fixtures.camera_files import write_raw
from tests.fixtures.commands import one_line
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed


def raw_video(folder: Path, frames: int = 40) -> Path:
    scene, random = SinusoidScene(1), np.random.default_rng(0)
    moved = np.sin(2.0 * np.pi * 5.0 * np.arange(frames) / 40.0)
    values = np.stack([photographed(scene.at(float(x), 0.0, shape=(96, 128)), random) for x in moved])
    return write_raw(folder, values, 8, 8, "Lower")


@pytest.mark.slow
def test_a_video_becomes_a_table_and_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = raw_video(tmp_path), tmp_path / "frames.csv"
    assert main(["track", str(path), "--rate-hz", "40", "--region", "0:0:128:90", "-o", str(out)]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert "40 of 40 frames measured" in line and "mostly at 5" in line and "40 frames/s" in line
    assert (
        out.read_text().startswith("frame,received_s,displacement_px")
        and len(out.read_text().splitlines()) == 41
    )


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["absent.mp4"], "no such file"),
        (["v.cih", "--region", "1:2:3"], "X:Y:W:H is needed"),
        (["v.cih", "--region", "0:0:4:4"], "at least 16 px"),
        (["v.cih", "--region", "100:0:90:90"], "beyond the image"),
        (["v.cih", "--rate-hz", "-3"], "above 0"),
        (["v.cih", "--window-px", "3"], "window_px"),
        (["garbage.mp4"], "garbage.mp4"),
        (["garbage.mp4", "--rate-hz", "10"], "contains no readable frame"),
        (["empty", "--rate-hz", "10"], "contains no readable frame"),
        (["empty"], "states no frame rate"),
    ],
)
def test_mistakes_give_one_line(
    words: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    raw_video(tmp_path, 2)
    (tmp_path / "garbage.mp4").write_bytes(np.random.default_rng(0).bytes(3000))
    (tmp_path / "empty").mkdir()
    assert main(["track", *words, "-o", "frames.csv"]) == 1
    assert says in one_line(capsys)
