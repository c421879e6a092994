"""Methods on recorded data, as `stillarm replay` runs them, with arrays for results."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stillarm.api.channels import Table
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import MethodFactory, all_methods
from stillarm.controller.replay.replay import MethodRun, read_run, replay_method

Methods = str | Sequence[str] | Mapping[str, MethodFactory]


@dataclass(frozen=True)
class Replayed:
    """A method's answers. estimates: time_s, deflection_m, deflection_std_m, delay_s, delay_std_s, status, trust; a row
    for each recorded cycle. frames: frame, received_s, delay_s, delay_std_s, status; a row for each visual sample."""

    method: str
    estimates: Table
    frames: Table


def replay(
    recording: str | Path,
    methods: Methods = "all",
    *,
    progress: Callable[[float, str], None] = lambda done, what: None,
) -> dict[str, Replayed]:
    """Run methods on a recording; their answers by name. Raises UserError for one that cannot be replayed.

    methods: names, "all" for every method of stillarm and of installed packages, or a mapping of names to factories of
    your own, each called with model, settings and the model's name. progress: receives the fraction done and the name.
    """
    run = read_run(open_recording(recording))
    if not run.fast:
        raise UserError(
            f"{recording}: holds no cycles (/fast), so there is nothing to replay; import a bundle with a fast.csv"
        )
    chosen: dict[str, MethodFactory | None]
    if isinstance(methods, Mapping):
        chosen = dict(methods)
    else:
        names = [methods] if isinstance(methods, str) else list(methods)
        chosen = dict.fromkeys(all_methods() if "all" in names else names)
    found = {}
    for place, (name, make) in enumerate(chosen.items()):

        def told(done: float, place: int = place, name: str = name) -> None:
            progress((place + done) / len(chosen), name)

        found[name] = _arrays(replay_method(run, name, told, make))
    progress(1.0, "")
    return found


def _arrays(run: MethodRun) -> Replayed:
    said, frames = run.estimates, run.frames
    return Replayed(
        run.method,
        Table(
            run.method,
            {
                "time_s": np.array(run.times_s),
                "deflection_m": np.array([one.deflection_m for one in said]),
                "deflection_std_m": np.array([one.deflection_std_m for one in said]),
                "delay_s": np.array([one.delay.delay_s for one in said]),
                "delay_std_s": np.array([one.delay.std_s for one in said]),
                "status": np.array([str(one.status) for one in said], object),
                "trust": np.array([str(one.trusted) for one in said], object),
            },
        ),
        Table(
            run.method,
            {
                "frame": np.array([frame for frame, _, _ in frames], np.int64),
                "received_s": np.array([received_s for _, received_s, _ in frames]),
                "delay_s": np.array([delay.delay_s for _, _, delay in frames]),
                "delay_std_s": np.array([delay.std_s for _, _, delay in frames]),
                "status": np.array([str(delay.status) for _, _, delay in frames], object),
            },
        ),
    )


__all__ = ["Methods", "Replayed", "replay"]
