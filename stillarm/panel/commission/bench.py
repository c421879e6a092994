"""Starts the check and the commissioning from the page, as the commands do, and gives their picture and verdict."""

from pathlib import Path
from typing import Any

from stillarm.common.files.configuration import load_assumed_model, load_configuration
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning.plan import Limits, within
from stillarm.panel.commission.steps import steps
from stillarm.panel.recordings.jobs import Job, Jobs

_MODEL_NAME = "commissioned_model.toml"


class Bench:
    """The commissioning of one rig. Results go to `commissioning/` in the panel's folder of recordings."""

    def __init__(self, configuration_path: Path, folder: Path) -> None:
        """folder: of the recordings."""
        self._path = configuration_path
        self._folder = folder / "commissioning"
        self._model_out = folder / _MODEL_NAME
        self._jobs = Jobs()

    def told(self) -> dict[str, Any]:
        """The steps and the state of both jobs. Raises UserError for a configuration or model that is wrong."""
        model = load_assumed_model(load_configuration(self._path), self._path)
        jobs = {name: job.told() for name in ("check", "commission") if (job := self._jobs.get(name))}
        return {
            "steps": steps(within(Limits(), model.drive)),
            "jobs": jobs,
            "model_out": _MODEL_NAME,
            "picture": self.picture().is_file(),
        }

    def picture(self) -> Path:
        """Path of the picture of the fit; the file is written after the fit."""
        return self._folder / "commissioning.png"

    async def check(self) -> Job:
        """Start the check, which moves nothing. Raises UserError where one runs."""
        return await self._jobs.start("check", "check", "--config", str(self._path))

    async def commission(self, *, controller_heard: bool) -> Job:
        """Start the moves; the page has asked. Raises UserError where a controller runs already."""
        if controller_heard:
            raise UserError("a controller is running; stop it first, since commissioning starts its own")
        return await self._jobs.start(
            "commission",
            *("commission", "--config", str(self._path), "-o", str(self._model_out)),
            *("--out", str(self._folder), "--yes", "--allow-non-realtime"),
            moves=True,
        )

    async def stop(self) -> None:
        """Stop both, as Ctrl-C does: the joint's command fades out."""
        await self._jobs.stop_all()
