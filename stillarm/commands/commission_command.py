"""`stillarm commission`: small watched moves of the rig, and the model file that they identify."""

import argparse
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from common.user_error import UserError
from stillarm.arguments import seconds
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
        help="no move carries the image further (120)",
    )
    parser.add_argument(
        "--strike-s",
        type=seconds,
        default=0.0,
        metavar="S",
        help="rest so many seconds more at the end; strike the arm by hand meanwhile (0)",
    )
    parser.add_argument("--yes", action="store_true", help="do not ask before the joint moves")
    parser.add_argument(
        "--allow-non-realtime", action="store_true", help="run without the privileges that keep the deadlines"
    )


def run(arguments: argparse.Namespace) -> int:
    """Ask, move, fit, write; 1 where the model is not good enough to damp by."""
    from common.configuration import load_assumed_model, load_configuration
    from common.model import check_model, length_of
    from common.output_folder import make_folder
    from diagnosis.commissioning.plan import Limits, within

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
    # only now what takes seconds to import: the question is to come at once
    from diagnosis.commissioning.live import LiveRig
    from diagnosis.commissioning.picture import draw
    from diagnosis.commissioning.procedure import commission
    from diagnosis.commissioning.verdict import marked
    from stillarm.progress import progress_bar

    with progress_bar("commission") as progress:
        rig = LiveRig(
            arguments.config,
            model,
            folder,
            allow_non_realtime=arguments.allow_non_realtime,
            progress=_Guide(progress, arguments.strike_s),
        )
        done = commission(
            rig.record,
            model,
            limits,
            strike_s=arguments.strike_s,
            tell=_tell,
            tick=lambda part, what: progress(0.9 + 0.1 * part),
        )
    found = done.found.model
    if done.verdict.good:
        date = datetime.now(UTC).date().isoformat()
        found = marked(found, done.found, date, str(folder / "moves.mcap"))
    check_model(found, str(arguments.model_out))
    print_parameters(done.found.parameters)
    draw(done, folder / "commissioning.png")
    write_model(found, arguments.model_out)
    print(f"{folder / 'commissioning.png'} shows it; name {arguments.model_out} as the configuration's model")
    print(f"{arguments.model_out}: {done.verdict.text}")
    return 0 if done.verdict.good else 1


class _Guide:
    """Shows how far it is, and says when it is time to strike the arm."""

    def __init__(self, progress: Callable[[float], None], strike_s: float) -> None:
        self._progress, self._strike_s, self._asked = progress, strike_s, strike_s == 0.0

    def __call__(self, name: str, done_s: float, of_s: float) -> None:
        """Both parts take about as long; the fit is the rest."""
        self._progress(0.45 * min(done_s / of_s, 1.0) + (0.45 if name == "moves" else 0.0))
        if name == "moves" and not self._asked and done_s > of_s - self._strike_s:
            self._asked = True
            print(f"strike the arm now, once or twice, within {self._strike_s:g} s", flush=True)


def _tell(line: str) -> None:
    print(line, flush=True)


def _positive(value: float, option: str) -> float:
    if not 0.0 < value < 1e6:
        raise UserError(f"{option} {value:g}: a number above zero is needed")
    return value


def _ask(what: str, agreed: bool) -> None:
    """Before anything moves. Raises UserError where nobody can say yes."""
    print(what)
    if agreed:
        return
    if not sys.stdin.isatty():
        raise UserError("commission: nobody is there to agree to that; add --yes when the arm is free")
    if input("Is the arm free to move? [y/N] ").strip().lower() not in ("y", "yes"):
        raise UserError("commission: not agreed to; nothing has moved")
