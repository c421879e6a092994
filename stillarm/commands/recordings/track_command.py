"""`stillarm track`: a video's displacement, as the visual channel of a CSV bundle."""

import argparse
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING

from stillarm.common.user_error import UserError, reason_of

if TYPE_CHECKING:
    from stillarm.common.files.configuration import Tracker
    from stillarm.supervisor.video_track import Region, VideoSummary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "video", type=Path, metavar="VIDEO", help="video, folder of images, or .cih with its .mraw"
    )
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FRAMES.csv", help="file to write")
    parser.add_argument(
        "--region",
        metavar="X:Y:W:H",
        help="part of the image to track, px from the left and upper edge (default: all of it)",
    )
    parser.add_argument(
        "--rate-hz",
        type=float,
        metavar="HZ",
        help="rate at which it was filmed; a file may play at another (default: what the file states)",
    )
    parser.add_argument("--window-px", type=int, metavar="PX", help="size of a feature's window (21)")
    parser.add_argument("--features", type=int, metavar="N", help="most features to track (100)")
    parser.add_argument("--min-inliers", type=int, metavar="N", help="fewest features that must agree (12)")
    parser.add_argument(
        "--shrink",
        type=int,
        choices=range(1, 9),
        default=1,
        metavar="N",
        help="reduce images by this factor first, for fast motion in large images (1)",
    )
    parser.add_argument("--blur-sigma-px", type=float, metavar="PX", help="smoothing before tracking (0)")


def run(arguments: argparse.Namespace) -> int:
    """Track, write the table, print one line."""
    from stillarm.supervisor.video_track import stated_rate_hz

    path: Path = arguments.video
    if not path.exists():
        raise UserError(f"{path}: no such file or folder; name a video, a folder of images or a .cih")
    config, region = _tracker(arguments), _region(arguments.region)
    given = arguments.rate_hz
    if given is not None and not (isfinite(given) and given > 0.0):
        raise UserError(f"--rate-hz {given}: a number above 0 is needed, frames per second")
    rate_hz = given if given is not None else stated_rate_hz(path)
    if rate_hz is None:
        raise UserError(f"{path}: states no frame rate; give --rate-hz")
    result = _track(path, config, region, rate_hz, arguments)
    stated = "" if given is not None else ", as the file states"
    print(f"{arguments.out}: {_line(result, rate_hz)}{stated}")
    return 0


def _track(
    path: Path, config: "Tracker", region: "Region | None", rate_hz: float, arguments: argparse.Namespace
) -> "VideoSummary":
    from stillarm.progress import progress_bar
    from stillarm.supervisor.video_track import COLUMNS, csv_row, stated_frames, summary, tracked

    frames = stated_frames(path)
    samples = []
    with progress_bar(f"track {path.name}") as show:
        for sample in tracked(path, config, region, arguments.shrink):
            samples.append(sample)
            show(min(1.0, len(samples) / frames) if frames else 0.0)
    result = summary(samples, rate_hz)
    if not result.measured:
        raise UserError(
            f"{path}: the tracker found nothing to follow in {result.frames} frames; choose a --region with texture, "
            "a smaller --window-px, a --shrink or fewer --min-inliers"
        )
    out: Path = arguments.out
    try:
        with out.open("w", encoding="utf-8") as file:
            file.write(COLUMNS + "\n")
            file.writelines(csv_row(sample, rate_hz) + "\n" for sample in samples)
    except OSError as error:
        raise UserError(f"{out}: cannot be written ({reason_of(error)}); name another with -o") from None
    return result


def _line(result: "VideoSummary", rate_hz: float) -> str:
    moved = f"{result.axis} moves by {result.span_px:.3g} px ({result.rms_px:.3g} px rms)"
    line = "" if isnan(result.frequency_hz) else f", mostly at {result.frequency_hz:.4g} Hz"
    return f"{result.measured} of {result.frames} frames measured; {moved}{line}; {rate_hz:g} frames/s"


def _tracker(arguments: argparse.Namespace) -> "Tracker":
    from stillarm.common.files.configuration import Tracker
    from stillarm.common.files.typed_toml import convert_tree

    names = ("window_px", "features", "min_inliers", "blur_sigma_px")
    given = {name: value for name in names if (value := getattr(arguments, name)) is not None}
    return convert_tree(given, Tracker, "track")


def _region(text: str | None) -> "Region | None":
    from stillarm.supervisor.video_track import SMALLEST_REGION_PX, Region

    if text is None:
        return None
    parts = text.split(":")
    if len(parts) != 4 or not all(part.isascii() and part.isdigit() for part in parts):
        raise UserError(f"--region {text}: X:Y:W:H is needed, four whole numbers of px")
    region = Region(*map(int, parts))
    if min(region.width, region.height) < SMALLEST_REGION_PX:
        raise UserError(f"--region {text}: at least {SMALLEST_REGION_PX} px high and wide are needed")
    return region
