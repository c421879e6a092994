"""Names stay in their folder, whatever is asked for."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.server.paths import confined


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    outer = tmp_path_factory.mktemp("outer")
    (outer / "secret.mcap").write_bytes(b"x")
    folder = outer / "recordings"
    (folder / "deep").mkdir(parents=True)
    for name in ("a.mcap", "b c.mcap", ".hidden.mcap", "notes.txt", "deep/d.mcap"):
        (folder / name).write_bytes(b"x")
    (folder / "out.mcap").symlink_to(outer / "secret.mcap")
    (folder / "loop.mcap").symlink_to("loop.mcap")
    return folder


@pytest.mark.parametrize("name", ["a.mcap", "b c.mcap"])
def test_what_lies_there_is_found(folder: Path, name: str) -> None:
    assert confined(folder, name, (".mcap",)) == (folder / name).resolve()


@pytest.mark.parametrize(
    "name",
    [
        *(
            "",
            ".",
            "..",
            "../secret.mcap",
            "..\\secret.mcap",
            "/etc/passwd",
            "deep/d.mcap",
            "deep",
            "out.mcap",
        ),
        *("loop.mcap", ".hidden.mcap", "notes.txt", "a.mcap\0", "a.mcap/", "none.mcap", "x" * 300 + ".mcap"),
        *("%2e%2e/secret.mcap", "....//secret.mcap", "\udcff.mcap"),
    ],
)
def test_nothing_else_is(folder: Path, name: str) -> None:
    assert confined(folder, name, (".mcap",)) is None


@given(st.text(alphabet="./\\amcp\0%2e", max_size=20))
def test_what_is_found_lies_in_the_folder(folder: Path, name: str) -> None:
    found = confined(folder, name, (".mcap",))
    assert found is None or found.parent == folder.resolve()
