"""One table of numbers, written by the test in each format; the reader must give the same numbers back."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROWS = 64
NAMES = ("time", "theta", "current")


def numbers() -> dict[str, NDArray[np.float64]]:
    """Three columns with awkward values: negative, tiny, large, and one that is not there."""
    random = np.random.default_rng(7)
    theta = random.normal(size=ROWS)
    theta[5] = np.nan
    current = random.normal(size=ROWS) * 1e-7
    current[3] = -123456.789
    return {"time": 0.002 * np.arange(ROWS), "theta": theta, "current": current}


def text(separator: str = ",", decimal: str = ".", header: bool = True) -> str:
    """The table as text, each number with all its digits."""
    columns = numbers()
    lines = [separator.join(columns)] if header else []
    for row in zip(*columns.values(), strict=True):
        fields = ["" if np.isnan(value) else repr(float(value)).replace(".", decimal) for value in row]
        lines.append(separator.join(fields))
    return "\n".join(lines) + "\n"


def mat5(path: Path) -> None:
    import scipy.io

    scipy.io.savemat(path, {name: values[:, None] for name, values in numbers().items()})


def mat73(path: Path) -> None:
    """As MATLAB writes it: 512 bytes of text, then HDF5, matrices transposed, their class as an attribute."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in numbers().items():
            dataset = file.create_dataset(name, data=values[None, :])
            dataset.attrs["MATLAB_class"] = np.bytes_(b"double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def parquet(path: Path) -> None:
    import pyarrow
    from pyarrow.parquet import write_table

    write_table(
        pyarrow.table({name: pyarrow.array(v, from_pandas=True) for name, v in numbers().items()}), path
    )


def npz(path: Path) -> None:
    np.savez(path, **numbers())


def npy(path: Path) -> None:
    """Records with named fields."""
    columns = numbers()
    held = np.zeros(ROWS, dtype=[(name, "f8") for name in columns])
    for name, values in columns.items():
        held[name] = values
    np.save(path, held)


def mcap_json(path: Path) -> None:
    import json

    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("anything", "jsonschema", b"{}")
        channel = writer.register_channel("/anything", "json", schema)
        for index, row in enumerate(zip(*numbers().values(), strict=True)):
            fields = {n: None if np.isnan(v) else float(v) for n, v in zip(NAMES, row, strict=True)}
            writer.add_message(channel, 2_000_000 * index, json.dumps(fields).encode(), 2_000_000 * index)
        writer.finish()


DEFINITION = """std_msgs/Header header
string[] name
float64[] position
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def ros2_bag(path: Path) -> None:
    """A folder as `ros2 bag record -s mcap` makes it, with one topic of joint states."""
    from mcap.writer import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    joint_state = store.types["sensor_msgs/msg/JointState"]
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    path.mkdir(parents=True)
    definition = DEFINITION.replace("float64[] effort", "float64[] velocity\nfloat64[] effort")
    with (path / "bag_0.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", definition.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        columns = numbers()
        for index in range(ROWS):
            message = joint_state(
                header=header(stamp=time(sec=5, nanosec=2_000_000 * index), frame_id=""),
                name=["shoulder", "elbow"],
                position=np.array([columns["theta"][index], 0.0]),
                velocity=np.array([]),
                effort=np.array([columns["current"][index], 1.0]),
            )
            data = bytes(store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
            writer.add_message(channel, 2_000_000 * index, data, 2_000_000 * index)
        writer.finish()
    (path / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")


WRITERS: dict[str, Callable[[Path], None]] = {
    "a.csv": lambda path: path.write_text(text()) and None,
    "v5.mat": mat5,
    "v73.mat": mat73,
    "a.parquet": parquet,
    "a.npz": npz,
    "a.npy": npy,
    "a.mcap": mcap_json,
}
