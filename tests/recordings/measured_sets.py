"""The measured data beside the repository, each as what a user would import: shortened copies, made in a folder.

../shared/data/README.md says where they are from and what is known of them. Nothing of them is kept.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.drivers.cameras.camera import EndOfStream
from stillarm.drivers.cameras.file_camera import FileCamera
from stillarm.supervisor.tracking.tracker import FeatureTracker

Array = NDArray[np.float64]

DATA = Path(__file__).parents[3] / "shared" / "data"
SILVERBOX_HZ = 1e7 / 2**14
KEPT_S = 8.0
ROBOT_ARM_HZ, F16_HZ = 500.0, 400.0  # not stated; a pair's rate scales frequencies only


@dataclass(frozen=True)
class MeasuredSet:
    """source: file or folder in DATA. make: writes what is imported into a folder, from the source; returns the
    arguments of the import. refused: words of the diagnosis that is refused, where nothing can be diagnosed."""

    source: str
    make: Callable[[Path, Path], list[str]]
    refused: str = ""


def bundle_start(source: Path, folder: Path) -> list[str]:
    """A bundle's first seconds."""
    model = source / "model.toml"
    (folder / "model.toml").write_text(model.read_text())
    until_s = None
    for name, time in (("fast.csv", 0), ("frames.csv", None)):
        lines = (source / name).read_text().splitlines()
        column = lines[0].split(",").index("received_s") if time is None else time
        times = [float(line.split(",")[column]) for line in lines[1:]]
        until_s = times[0] + KEPT_S if until_s is None else until_s
        kept = [line for line, at in zip(lines[1:], times, strict=True) if at < until_s]
        (folder / name).write_text("\n".join([lines[0], *kept]) + "\n")
    return ["import", str(folder)]


def pair_rows(
    first: int, count: int, columns: tuple[str, str], rate_hz: float
) -> Callable[[Path, Path], list[str]]:
    """Some rows of a file of columns, with its first row where that names them."""

    def make(source: Path, folder: Path) -> list[str]:
        lines = source.read_text().splitlines()
        head = lines[:1] if any(letter.isalpha() and letter != "e" for letter in lines[0]) else []
        body = lines[len(head) :][first : first + count]
        file = folder / source.name
        file.write_text("\n".join([*head, *body]) + "\n")
        given, answer = columns
        maps = ["--map", f"input={given}", "--map", f"output={answer}"]
        return ["import", str(file), *maps, "--rate-hz", repr(rate_hz)]

    return make


def _write(path: Path, columns: dict[str, Array]) -> None:
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines = [",".join("" if np.isnan(value) else repr(value) for value in row) for row in rows]
    path.write_text("\n".join([",".join(columns), *lines]) + "\n")


def _model(folder: Path, length_m: float, hz: float, camera: str = "") -> None:
    (folder / "model.toml").write_text(
        f"[arm]\nlength_m = {length_m}\n[[arm.modes]]\nfrequency_hz = {hz}\n{camera}"
    )


def quanser_tracking(source: Path, folder: Path) -> list[str]:
    """Joint and deflection of the first stage, from a clock that reads 82 s: 8 s of twenty."""
    data = loadmat(source)
    time, joint = data["data_th11"][:4000, 0], data["data_th11"][:4000, 2]
    length_m = float(data["L1"].item())
    bend = np.radians(data["data_th12"][:4000, 2]) * length_m
    _write(
        folder / "fast.csv",
        {"time_s": time, "joint_position_rad": np.radians(joint), "deflection_m": bend},
    )
    _model(folder, length_m, 3.0)
    return ["import", str(folder)]


def quanser_step(source: Path, folder: Path) -> list[str]:
    """A step run of 4 s: joint, its rate, deflection."""
    data = loadmat(source)
    columns = {
        "time_s": data["time"][:, 0],
        "joint_position_rad": data["theta11"][:, 0],
        "joint_velocity_rad_s": data["theta11_dot"][:, 0],
        "deflection_m": 0.202 * data["theta12"][:, 0],
    }
    _write(folder / "fast.csv", {name: column.astype(float) for name, column in columns.items()})
    _model(folder, 0.202, 3.0)
    return ["import", str(folder)]


def phone(source: Path, folder: Path) -> list[str]:
    """The angle about one axis as a joint's, on the phone's own clock, and the images' displacement."""
    text = next(source.glob("*.txt")).read_text().splitlines()
    rows = [
        [float(word) for word in line.replace("[", "").replace("]", "").split(",")]
        for line in text[2:]
        if line
    ]
    table = np.array(rows)
    begun_s = 1e-3 * float(text[0])
    time = table[:, 0] * 1e-3
    angle = np.unwrap(np.arctan2(table[:, 5], table[:, 2]))
    kept = (time >= begun_s) & (time < begun_s + KEPT_S)
    order = np.unique(time[kept], return_index=True)[1]
    _write(folder / "fast.csv", {"time_s": time[kept][order], "joint_position_rad": angle[kept][order]})
    moved = displacement_px(next(source.glob("*.mp4")), 60)
    arrived = begun_s + 0.5 + np.arange(len(moved)) / 15.0
    _write(folder / "frames.csv", {"received_s": arrived, "displacement_px": moved})
    _model(folder, 1.0, 1.0, "[camera]\nframe_rate_hz = 15.0\nexposure_s = 0.03\n")
    return ["import", str(folder)]


def tuning_fork(source: Path, folder: Path) -> list[str]:
    """A tine's displacement, and no row but times: at the 50 frames a second of the file, five times slower than it
    was filmed, as 1.2 s would be too short."""
    moved = displacement_px(source, 300, (slice(60, 420), slice(290, 342)))
    time = np.arange(len(moved)) / 50.0
    _write(folder / "fast.csv", {"time_s": np.arange(0.0, time[-1] + 0.1, 0.001)})
    _write(folder / "frames.csv", {"received_s": time + 0.05, "displacement_px": moved})
    _model(folder, 0.1, 6.2, "[camera]\nframe_rate_hz = 50.0\nexposure_s = 0.01\n")
    return ["import", str(folder)]


def beam(played_hz: float, hz: float) -> Callable[[Path, Path], list[str]]:
    """A high-speed video of a beam, played at a rate that a camera may have; hz: of its vibration at that rate."""

    def make(source: Path, folder: Path) -> list[str]:
        moved = tracked_px(mraw_images(source))
        time = np.arange(len(moved)) / played_hz
        _write(folder / "fast.csv", {"time_s": np.arange(0.0, time[-1] + 0.1, 0.001)})
        _write(folder / "frames.csv", {"received_s": time + 0.05, "displacement_px": moved})
        _model(folder, 0.1, hz, f"[camera]\nframe_rate_hz = {played_hz}\nexposure_s = 0.001\n")
        return ["import", str(folder)]

    return make


def mraw_images(path: Path) -> NDArray[np.uint8]:
    """The frames of a Photron file, (n, height, width), of the size and depth that the .cih beside it tells."""
    header = dict(
        line.split(" : ", 1) for line in path.with_suffix(".cih").read_text().splitlines() if " : " in line
    )
    bits, effective = int(header["Color Bit"]), int(header["EffectiveBit Depth"])
    frames = np.fromfile(path, np.uint16 if bits == 16 else np.uint8)
    frames = frames.reshape(-1, int(header["Image Height"]), int(header["Image Width"]))
    return np.asarray(frames >> max(0, effective - 8), np.uint8)


def tracked_px(images: NDArray[np.uint8]) -> Array:
    """The tracker's y displacement of each frame, NaN where it was lost; (n,)."""
    tracker = FeatureTracker(Tracker())
    found = [tracker.track(np.ascontiguousarray(image)) for image in images]
    return np.array([one.dy if one.status == TrackingStatus.MEASURED else np.nan for one in found])


def displacement_px(path: Path, frames: int, crop: tuple[slice, ...] = (slice(None),)) -> Array:
    """The tracker's x displacement of each frame, NaN where it was lost; (n,)."""
    camera, tracker = FileCamera(path), FeatureTracker(Tracker())
    found: list[float] = []
    camera.start()
    try:
        while len(found) < frames:
            one = tracker.track(np.ascontiguousarray(camera.read(0.0).image[crop]))
            found.append(one.dx if one.status == TrackingStatus.MEASURED else np.nan)
    except EndOfStream:
        pass
    camera.close()
    return np.array(found)


def _steps() -> dict[str, MeasuredSet]:
    names = [f"{kind}_step_{angle}deg_run01" for kind in ("hinf", "lqg") for angle in ("10", "neg_30")]
    return {
        f"quanser {name}": MeasuredSet(f"quanser_flexible_link/{name}.mat", quanser_step) for name in names
    }


SETS: dict[str, MeasuredSet] = {
    "silverbox, growing noise": MeasuredSet(
        "silverbox/SNLS80mV.csv", pair_rows(37000, 2500, ("V1", "V2"), SILVERBOX_HZ)
    ),
    "silverbox, multisines": MeasuredSet(
        "silverbox/SNLS80mV.csv", pair_rows(60000, 5000, ("V1", "V2"), SILVERBOX_HZ)
    ),
    "robot arm": MeasuredSet("robot_arm/robot_arm.dat", pair_rows(0, 1024, ("1", "2"), ROBOT_ARM_HZ)),
    "F-16": MeasuredSet("f16_vibration/f-16.txt", pair_rows(0, 4096, ("1", "2"), F16_HZ)),
    "quanser lqr": MeasuredSet("quanser_flexible_link/lqr_full_10deg.mat", quanser_tracking),
    **_steps(),
    "phone": MeasuredSet("phone_rotation", phone),
    "tuning fork": MeasuredSet("tuning_fork_video/tuning_hz32_fps250_50-1_640x420.mp4", tuning_fork),
    # The tracker loses both: the one bends from column to column, the other has 15 grey levels in 75 frames.
    "beam, synthetic": MeasuredSet(
        "beam_video/data_synthetic.mraw", beam(20.0, 1.0), "no measured channel"
    ),
    "beam, showcase": MeasuredSet("beam_video/data_showcase.mraw", beam(20.0, 1.0), "no measured channel"),
    "beam, speckle": MeasuredSet("beam_video/Speckle_beam_500.mraw", beam(100.0, 5.0)),
    **{f"live demo {n}": MeasuredSet(f"live_demo/run_{n}", bundle_start) for n in (3, 12, 13)},
    **{f"stranger {n}": MeasuredSet(f"strangers/delay_{n}", bundle_start) for n in range(1, 5)},
    **{f"stranger case {n}": MeasuredSet(f"strangers/case_{n:02d}", bundle_start) for n in range(1, 19)},
}  # fmt: skip
