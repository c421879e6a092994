"""`stillarm calibrate`: the model's parameters from a recording, with uncertainties."""

import argparse
from datetime import UTC, datetime
from pathlib import Path

from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.found_model import print_parameters, write_model


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "recording", type=Path, metavar="REC", help="recording (MCAP) that contains moves or a ring-down"
    )
    parser.add_argument("--model", type=Path, required=True, metavar="FILE", help="model file to start from")
    parser.add_argument(
        "-o", dest="out", type=Path, required=True, metavar="FILE", help="model file to write"
    )


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, print every parameter with its uncertainty, write the model file."""
    one_blas_thread()
    from stillarm.common.files.model import check_model, load_model
    from stillarm.common.recording.reader import open_recording
    from stillarm.progress import progress_bar

    with progress_bar("calibrate") as progress:
        # these imports take over a second: the bar comes first
        from stillarm.diagnosis.calibration.calibrate import calibrate
        from stillarm.diagnosis.commissioning.verdict import judge, marked
        from stillarm.diagnosis.data.reading import read_measured
        from stillarm.diagnosis.physics.ahead import compile_ahead

        model = load_model(arguments.model)
        recording = open_recording(arguments.recording)
        measured = read_measured(recording, model)
        compile_ahead()
        found = calibrate(measured, model, lambda done, what: progress(done))
    verdict = judge(found, measured)
    made = found.model
    if verdict.good and not measured.pair:
        made = marked(made, found, recording_date(recording.header.origin_unix_ns), str(arguments.recording))
    check_model(made, str(arguments.out))
    print_parameters(found.parameters)
    write_model(made, arguments.out)
    print(f"  {verdict.text}")
    shown = {name: error for name, error in found.nrmse.items() if name != "arrival"} or found.nrmse
    worst = max(shown.items(), key=lambda one: one[1])
    print(
        f"{arguments.out}: calibrated from {arguments.recording}; the simulation in free run leaves "
        f"{100.0 * worst[1]:.2g} % of {worst[0]} at most"
    )
    return 0


def recording_date(origin_unix_ns: int) -> str:
    """The day of a recording, as an ISO date; today for a recording in virtual time."""
    made = datetime.fromtimestamp(1e-9 * origin_unix_ns, UTC) if origin_unix_ns else datetime.now(UTC)
    return made.date().isoformat()
