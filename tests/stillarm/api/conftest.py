"""A recording that the façade's tests share."""

from pathlib import Path

import pytest

import stillarm
from tests.fixtures.imports import ROOT


@pytest.fixture(scope="session")
def short_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two simulated seconds, with the truth beside it."""
    folder = tmp_path_factory.mktemp("short")
    (folder / "short.toml").write_text("duration_s = 2.0\n")
    made = stillarm.simulate(ROOT / "configs" / "model.toml", folder / "short.toml", 1, out=folder)
    return made.recording.path
