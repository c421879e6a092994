"""`stillarm commission` refuses in one line before anything is opened or moved."""

from pathlib import Path

import pytest

from stillarm.main import main


@pytest.fixture
def config(tmp_path: Path) -> Path:
    (tmp_path / "model.toml").write_text("[arm]\nlength_m = 1.0\n")
    path = tmp_path / "config.toml"
    path.write_text("")
    return path


@pytest.mark.parametrize(
    ("words", "model", "expected"),
    [
        ((), "[arm]\nlength_m = 1.0\n", "no terminal to ask at; add --yes if the arm is free to move"),
        (("--yes",), "", "arm.length_m: needed for a deflection and absent"),
        (
            ("--max-angle-rad", "-1"),
            "[arm]\nlength_m = 1.0\n",
            "--max-angle-rad -1: a number above zero is needed",
        ),
        (("--max-velocity-rad-s", "0.001"), "[arm]\nlength_m = 1.0\n", "leave no room for a move"),
        (("--max-velocity-rad-s", "nan"), "[arm]\nlength_m = 1.0\n", "a number above zero is needed"),
    ],
)
def test_one_line_and_nothing_moves(
    config: Path, words: tuple[str, ...], model: str, expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (config.parent / "model.toml").write_text(model)
    out = config.parent / "found.toml"
    assert main(["commission", "--config", str(config), "-o", str(out), *words]) == 1
    said = capsys.readouterr().err
    assert expected in said and said.count("\n") == 1 and "Traceback" not in said
    assert not out.exists()
