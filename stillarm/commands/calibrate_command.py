"""`stillarm calibrate`: the model's parameters from a recording, with uncertainties."""

import argparse
from pathlib import Path

from common.user_error import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "recording", type=Path, metavar="REC", help="recording (MCAP) with moves or a ring-down in it"
    )
    parser.add_argument("--model", type=Path, required=True, metavar="FILE", help="model file to start from")
    parser.add_argument(
        "-o", dest="out", type=Path, required=True, metavar="FILE", help="model file to write"
    )


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, print every parameter with its uncertainty, write the model file."""
    from common.model import check_model, load_model
    from common.recording.reader import open_recording
    from diagnosis.calibrate import calibrate
    from diagnosis.diagnose import model_text
    from diagnosis.measured import read_measured
    from stillarm.progress import progress_bar

    model = load_model(arguments.model)
    measured = read_measured(open_recording(arguments.recording), model)
    with progress_bar("calibrate") as progress:
        found = calibrate(measured, model, lambda done, what: progress(done))
    check_model(found.model, str(arguments.out))
    for key, (value, std) in found.parameters.items():
        print(f"  {key:<34} {value:>12.6g} +- {std:.2g}")
    try:
        arguments.out.write_text(model_text(found.model))
    except OSError as error:
        raise UserError(
            f"{arguments.out}: cannot be written ({error.strerror}); name another file with -o"
        ) from None
    shown = {name: error for name, error in found.nrmse.items() if name != "arrival"} or found.nrmse
    worst = max(shown.items(), key=lambda one: one[1])
    print(
        f"{arguments.out}: calibrated from {arguments.recording}; the simulation in free run leaves "
        f"{100.0 * worst[1]:.2g} % of {worst[0]} at most"
    )
    return 0
