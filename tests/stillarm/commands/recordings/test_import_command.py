"""`stillarm import --look` and `--as`, as a user types them."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.main import main
from tests.fixtures.commands import one_line


def rig(path: Path) -> Path:
    time = np.arange(4000) / 1000.0
    random = np.random.default_rng(0)
    angle, rate = np.zeros(4000), np.zeros(4000)
    for hz, phase in zip(random.uniform(0.5, 6.0, 9), random.uniform(0.0, 6.28, 9), strict=True):
        angle += 3.0 * np.sin(6.2832 * hz * time + phase) / hz
        rate += 3.0 * 6.2832 * np.cos(6.2832 * hz * time + phase)
    strain = np.roll(rate, 30) ** 3
    lines = ["t [s];theta [deg];omega [deg/s];strain_gauge"]
    lines += [
        ";".join(f"{v:.8f}".replace(".", ",") for v in row)
        for row in zip(time, angle, rate, strain, strict=True)
    ]
    path.write_text("\n".join(lines))
    return path


@pytest.mark.slow
def test_look_then_import(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = rig(tmp_path / "rig.csv")
    assert main(["import", str(source), "--look"]) == 0
    printed = capsys.readouterr().out
    assert "1000 Hz" in printed and "joint_position_rad" in printed and "derivative of theta [deg]" in printed
    description = tmp_path / "rig.csv.import.toml"
    assert description.exists() and (tmp_path / "rig.csv.import.png").stat().st_size > 5000
    out = tmp_path / "rec.mcap"
    assert main(["import", str(source), "--as", str(description), "-o", str(out)]) == 0
    assert "4000 rows in /fast" in capsys.readouterr().out
    fast = open_recording(out).columns("/fast")
    text = source.read_text().replace(",", ".").splitlines()[1:]
    given = np.array([[float(field) for field in line.split(";")] for line in text])
    np.testing.assert_allclose(fast["joint_position_rad"], np.radians(given[:, 1]), rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(fast["joint_velocity_rad_s"], np.radians(given[:, 2]), rtol=1e-14, atol=1e-15)
    np.testing.assert_array_equal(fast["strain"], given[:, 3])


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["a.csv"], "-o: needed"),
        (["a.csv", "--look", "--map", "input=1"], "one of them at a time"),
        (["a.csv", "--look"], "a.csv"),
        (["a.csv", "--model", "m.toml", "-o", "r.mcap"], "--model: only with --as"),
        (["a.csv", "--as", "absent.toml", "-o", "r.mcap"], "absent.toml"),
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
    assert main(["import", *words]) == 1
    assert says in one_line(capsys)


def test_a_description_is_named_toml(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.csv").write_text("t,x\n" + "".join(f"{i},{i * i}\n" for i in range(20)))
    assert main(["import", str(tmp_path / "a.csv"), "--look", "-o", str(tmp_path / "rec.mcap")]) == 1
    assert "name it .toml" in one_line(capsys)
