"""`stillarm commission`: identifies the rig's model file from small, supervised moves."""

import argparse
import contextlib
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from stillarm.arguments import seconds
from stillarm.common.user_error import UserError
from stillarm.found_model import print_parameters, write_model


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML) of the rig"
    )
    parser.add_argument(
        "-o", dest="model_out", type=Path, required=True, metavar="FILE", help="model file to write"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder for recordings and picture (commissioning, beside the model)",
    )
    parser.add_argument(
        "--max-angle-rad", type=float, default=0.06, metavar="A", help="no move goes further (0.06)"
    )
    parser.add_argument(
        "--max-velocity-rad-s", type=float, default=0.15, metavar="V", help="no move is faster (0.15)"
    )
    parser.add_argument(
        "--max-image-px",
        type=float,
        default=120.0,
        metavar="P",
        help="no move shifts the image further (120)",
    )
    parser.add_argument(
        "--strike-s",
        type=seconds,
        default=0.0,
        metavar="S",
        help="extra seconds of rest at the end, in which you strike the arm by hand (0)",
    )
    parser.add_argument("--yes", action="store_true", help="do not ask before the joint moves")
    parser.add_argument(
        "--allow-non-realtime", action="store_true", help="run without the privileges that keep the deadlines"
    )


def run(arguments: argparse.Namespace) -> int:
    """Ask, move, fit, write. Returns 1 if the model is not good enough for damping."""
    from stillarm.common.files.configuration import load_assumed_model, load_configuration
    from stillarm.common.files.model import check_model, length_of
    from stillarm.common.files.output_folder import make_folder
    from stillarm.diagnosis.commissioning.plan import Limits, within

    configuration = load_configuration(arguments.config)
    model = load_assumed_model(configuration, arguments.config)
    length_of(model, str(arguments.config))
    limits = Limits(
        _positive(arguments.max_angle_rad, "--max-angle-rad"),
        _positive(arguments.max_velocity_rad_s, "--max-velocity-rad-s"),
        image_px=_positive(arguments.max_image_px, "--max-image-px"),
    )
    allowed = within(limits, model.drive)
    folder = make_folder(arguments.out or arguments.model_out.parent / "commissioning")
    _ask(
        f"The joint will move by at most {allowed.angle_rad:g} rad at up to {allowed.velocity_rad_s:g} rad/s, for "
        f"about a minute and a half. Ctrl-C stops it, and so does `stillarm operate stop --config {arguments.config}`.",
        arguments.yes,
    )
    # these imports take seconds: the question must come first
    from stillarm.diagnosis.commissioning.live import LiveRig
    from stillarm.diagnosis.commissioning.picture import draw
    from stillarm.diagnosis.commissioning.procedure import commission
    from stillarm.diagnosis.commissioning.verdict import marked
    from stillarm.progress import progress_bar

    with (
        progress_bar("commission") as progress,
        contextlib.closing(
            LiveRig(
                arguments.config,
                model,
                folder,
                allow_non_realtime=arguments.allow_non_realtime,
                progress=_Guide(progress, arguments.strike_s),
            )
        ) as rig,
    ):
        done = commission(
            rig.record,
            model,
            limits,
            strike_s=arguments.strike_s,
            rest=rig.rest,
            tell=_tell,
            tick=lambda part, what: progress(0.9 + 0.1 * part),
        )
    found = done.found.model
    if done.verdict.good:
        date = datetime.now(UTC).date().isoformat()
        found = marked(found, done.found, date, str(folder / Path(done.measured.name).name))
    check_model(found, str(arguments.model_out))
    print_parameters(done.found.parameters)
    draw(done, folder / "commissioning.png")
    write_model(found, arguments.model_out)
    print(
        f"{folder / 'commissioning.png'} shows the fit; name {arguments.model_out} as the configuration's model"
    )
    print(f"{arguments.model_out}: {done.verdict.text}")
    return 0 if done.verdict.good else 1


class _Guide:
    """Shows the progress, and asks the operator to strike the arm when it is time."""

    def __init__(self, progress: Callable[[float], None], strike_s: float) -> None:
        self._progress, self._strike_s = progress, strike_s
        self._asked_in = ""

    def __call__(self, name: str, done_s: float, of_s: float) -> None:
        """Update the progress. Both parts take about equally long, and the fit is the rest; moves may be repeated."""
        moves = name != "probe"
        self._progress(0.45 * min(done_s / of_s, 1.0) + (0.45 if moves else 0.0))
        if moves and self._strike_s > 0.0 and self._asked_in != name and done_s > of_s - self._strike_s:
            self._asked_in = name
            print(f"strike the arm now, once or twice, within {self._strike_s:g} s", flush=True)


def _tell(line: str) -> None:
    print(line, flush=True)


def _positive(value: float, option: str) -> float:
    if not 0.0 < value < 1e6:
        raise UserError(f"{option} {value:g}: a number above zero is needed")
    return value


def _ask(what: str, agreed: bool) -> None:
    """Ask before anything moves. Raises UserError if nobody can answer, or the answer is no."""
    print(what)
    if agreed:
        return
    if not sys.stdin.isatty():
        raise UserError("commission: no terminal to ask at; add --yes if the arm is free to move")
    if input("Is the arm free to move? [y/N] ").strip().lower() not in ("y", "yes"):
        raise UserError("commission: not confirmed; nothing has moved")
