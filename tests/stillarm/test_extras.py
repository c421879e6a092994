"""Lean installs: what is missing is one line with its remedy, and the table agrees with pyproject.toml and the code."""

import subprocess
import sys
import tomllib

import pytest

from stillarm import main as command_line
from stillarm.common.user_error import UserError
from stillarm.extras import NEEDED_BY, PACKAGES, missing_package, require
from tests.fixtures.commands import one_line
from tests.fixtures.imports import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
HEAVY = ("scipy", "numba", "matplotlib", "cv2")


def test_a_missing_package_is_named_with_the_command_that_installs_it() -> None:
    with pytest.raises(
        UserError,
        match=r"demo: .*cv2, matplotlib, numba, scipy, threadpoolctl; .*stillarm\[vision,diagnosis\]",
    ):
        require("demo", lambda name: False)
    with pytest.raises(UserError, match=r"diagnose: not installed here: numba; .*'stillarm\[diagnosis\]'"):
        require("diagnose", lambda name: name != "numba")
    require("demo", lambda name: True)
    require("controller", lambda name: False)


def test_a_failed_import_within_a_command_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the table cannot know beforehand: an option, or one benchmark of many."""

    def lacks(arguments: object) -> int:
        raise ModuleNotFoundError("No module named 'numba'", name="numba.core")

    monkeypatch.setattr("stillarm.commands.recordings.replay_command.run", lacks)
    assert command_line.main(["replay", "rec.mcap"]) == 1
    assert "pip install 'stillarm[diagnosis]'" in one_line(capsys)


def test_a_module_of_our_own_that_is_missing_stays_a_fault() -> None:
    assert missing_package(ModuleNotFoundError("no", name="stillarm.nowhere")) is None
    assert missing_package(ModuleNotFoundError("no")) is None


def test_every_extra_of_the_table_is_one_of_the_project() -> None:
    extras = PROJECT["optional-dependencies"]
    assert set(PACKAGES) <= set(extras)
    assert {extra for needed in NEEDED_BY.values() for extra in needed} <= set(PACKAGES)
    assert set(NEEDED_BY) <= set(command_line.COMMANDS)
    assert not any(name in word for word in PROJECT["dependencies"] for name in (*HEAVY, "opencv"))


@pytest.mark.slow
def test_without_the_extras_the_controller_and_every_light_command_import() -> None:
    """The heavy packages are made unimportable, as in a base install; the supervisor's has OpenCV."""
    hide = "import sys; sys.modules.update(dict.fromkeys({hidden!r})); "
    controller = (
        "import stillarm.controller.loop.daemon, stillarm.preflight.walk, stillarm.controller.replay.replay"
    )
    for hidden, code in ((HEAVY, controller), (HEAVY[:3], "import stillarm.supervisor.daemon")):
        words = [sys.executable, "-c", hide.format(hidden=hidden) + code]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
