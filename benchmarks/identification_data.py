"""Measured pairs of an input and an output, with the samples that are fitted and those that are held out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SILVERBOX_HZ = 1e7 / 2**14
_GROWING = 40500  # samples: noise of growing amplitude, held out
_FITTED = 30000  # samples of the multisines after it
_ROBOT_ARM_HZ = 500.0  # not stated: it scales frequencies only
_ROBOT_ARM_FITTED = 700  # of 1024 samples
_F16_HZ = 400.0
_F16_SAMPLES, _F16_FITTED = 8192, 6144  # of 32768: all of a period of the sweep, and a third of one


@dataclass(frozen=True)
class Pair:
    """One input, one output; `train` and `test` are spans of samples. accelerates: the output is an acceleration of
    what a force or torque drives."""

    name: str
    file: Path
    columns: dict[str, str]
    u: Array
    y: Array
    rate_hz: float
    train: slice
    test: slice
    accelerates: bool = False


def silverbox(folder: Path) -> Pair | None:
    """The electronic Duffing oscillator of Wigren and Schoukens (2013); None without the data."""
    file = folder / "silverbox" / "SNLS80mV.csv"
    if not file.is_file():
        return None
    data = np.genfromtxt(file, delimiter=",", skip_header=1, usecols=(0, 1))[: _GROWING + _FITTED]
    train = slice(_GROWING, _GROWING + _FITTED)
    columns = {"input": "V1", "output": "V2"}
    return Pair("Silverbox", file, columns, data[:, 0], data[:, 1], SILVERBOX_HZ, train, slice(0, _GROWING))


def robot_arm(folder: Path) -> Pair | None:
    """A flexible arm's reaction torque and acceleration (DaISy 96-009); None without the data."""
    file = folder / "robot_arm" / "robot_arm.dat"
    if not file.is_file():
        return None
    data = np.loadtxt(file)
    train, test = slice(0, _ROBOT_ARM_FITTED), slice(_ROBOT_ARM_FITTED, len(data))
    return Pair("robot_arm", file, {}, data[:, 0], data[:, 1], _ROBOT_ARM_HZ, train, test, accelerates=True)


def f16(folder: Path) -> Pair | None:
    """Force and acceleration of an aircraft's ground vibration test (nonlinearbenchmark.org); None without the data.
    Of its three columns the second is the voltage that the shaker was given: above the sweep's 15 Hz it holds nothing
    (1e-13 of its density below), where the first, the force that was measured, has harmonics (1e-5)."""
    file = folder / "f16_vibration" / "f-16.txt"
    if not file.is_file():
        return None
    data = np.loadtxt(file, delimiter=",", max_rows=_F16_SAMPLES)
    train, test = slice(0, _F16_FITTED), slice(_F16_FITTED, len(data))
    return Pair("f16_vibration", file, {}, data[:, 0], data[:, 2], _F16_HZ, train, test, accelerates=True)


def pairs(folder: Path) -> list[Pair]:
    """Those whose data are there."""
    found = (one(folder) for one in (silverbox, robot_arm, f16))
    return [one for one in found if one is not None]
