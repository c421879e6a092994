"""A run of the whole loop in virtual time, as `stillarm simulate` makes it, with its truth beside it."""

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from stillarm.api.channels import Channels, load
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError


@dataclass(frozen=True)
class Simulated:
    """The controller's recording, and the simulated rig's truth. recording.path and truth.path are files."""

    recording: Channels
    truth: Channels


def simulate(
    model: str | Path | Model,
    scenario: str | Path = "demo",
    seed: int = 0,
    *,
    assumed: str | Path | Model | None = None,
    method: str | None = None,
    images: bool = False,
    out: str | Path | None = None,
) -> Simulated:
    """Simulate a scenario. The same arguments give the same files, to the byte. Raises UserError.

    model: what the rig truly is, a file or a Model. scenario: by name, or a file. assumed: the controller's model;
    default: the true one. method: the controller's; default: the configuration's. images: render and track images
    instead of drawing the tracker's errors. out: folder for recording.mcap and truth.mcap; default: a new one among the
    system's temporary files.
    """
    folder = Path(tempfile.mkdtemp(prefix="stillarm-")) if out is None else Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    recording, truth = folder / "recording.mcap", folder / "truth.mcap"
    words = ["--model", _file(model, folder / "model.toml"), "--scenario", str(scenario), "--seed", str(seed)]
    words += ["-o", str(recording), "--truth", str(truth)]
    if assumed is not None:
        words += ["--assumed-model", _file(assumed, folder / "assumed.toml")]
    words += ["--method", method] if method is not None else []
    words += ["--images"] if images else []
    # A process of its own: what starts processes must not run in a script that lacks the guard of __main__.
    command = [sys.executable, "-m", "stillarm", "simulate", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise UserError(done.stderr.strip().removeprefix("stillarm: "))
    return Simulated(load(recording), load(truth))


def _file(model: str | Path | Model, path: Path) -> str:
    if not isinstance(model, Model):
        return str(model)
    from stillarm.diagnosis.report.extended_model import model_text

    path.write_text(model_text(model))
    return str(path)


__all__ = ["Simulated", "simulate"]
