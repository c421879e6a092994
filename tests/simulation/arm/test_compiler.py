"""What is compiled is kept on disk, and no longer than it is true."""

from pathlib import Path
from typing import Any, cast

from stillarm.simulation.arm import compiler
from stillarm.simulation.arm.free_run import free_run


def test_what_is_kept_is_of_all_of_the_arms_files_as_they_are() -> None:
    """numba's own stamp is of one file, and compiled functions call those of others."""
    files = sorted(Path(compiler.__file__).parent.glob("*.py"))
    assert [name for name, _, _ in compiler.SOURCES] == [one.name for one in files]
    cache = cast(Any, free_run)._cache._cache_file
    assert cache._source_stamp == compiler.SOURCES


def test_another_version_of_a_file_is_compiled_anew() -> None:
    @compiler.compiled
    def twice(x: float) -> float:
        return 2.0 * x

    twice(1.0)
    kept = cast(Any, twice)._cache._cache_file
    assert kept._load_index()
    kept._source_stamp = (("stepper.py", 0, 0),)
    assert not kept._load_index()


def test_what_calls_the_arms_functions_is_kept_until_its_own_files_change_too(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text("")

    @compiler.compiled_from(str(file))
    def twice(x: float) -> float:
        return 2.0 * x

    *arm, own = cast(Any, twice)._cache._cache_file._source_stamp
    assert tuple(arm) == compiler.SOURCES
    assert own == ("own.py", file.stat().st_mtime_ns, file.stat().st_size)
