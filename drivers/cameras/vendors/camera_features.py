"""Sets a camera by the names of GenICam's Standard Features Naming Convention: Basler, GenICam, Aravis, IDS peak.

Each value is written and read back; a deviation is reported in one line. Older cameras have other names for the same
features: ExposureTimeAbs, AcquisitionFrameRateAbs, GainRaw.
"""

from collections.abc import Callable
from typing import Any, Protocol

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError

_TOLERANCE = 0.01  # relative difference from the requested value that is not reported
_EXPOSURE = ("ExposureTime", "ExposureTimeAbs")
_RATE = ("AcquisitionFrameRate", "AcquisitionFrameRateAbs")
_GAIN = ("Gain", "GainRaw")


class Features(Protocol):
    """A camera's features by name."""

    def write(self, name: str, value: float | str | bool) -> bool:
        """Set a feature. Returns False if the camera does not have it, or refuses the value."""

    def number(self, name: str) -> float | None:
        """A feature's number; None if the camera does not have it."""


class NodeFeatures:
    """Features through a maker's own calls, which raise one of `errors` for what a camera lacks or refuses."""

    def __init__(
        self,
        put: Callable[[str, float | str | bool], None],
        get: Callable[[str], Any],
        errors: tuple[type[Exception], ...],
    ) -> None:
        """put: sets a feature; a number comes as float, and as int where that is refused. get: a feature's number."""
        self._put, self._get, self._errors = put, get, errors

    def write(self, name: str, value: float | str | bool) -> bool:
        """Set a feature; as an integer if it is one."""
        try:
            if isinstance(value, bool | str):
                self._put(name, value)
            else:
                try:
                    self._put(name, float(value))
                except self._errors:
                    self._put(name, round(value))
        except self._errors:
            return False
        return True

    def number(self, name: str) -> float | None:
        """A feature's number."""
        try:
            return float(self._get(name))
        except self._errors:
            return None


def set_features(features: Features, config: CameraDevice) -> list[str]:
    """Set the configured values. Returns a line for each that the camera refused.

    Raises UserError for an image size that it refuses and for a trigger that it does not have; all other settings are
    optional.
    """
    for key, name, size in (
        ("width_px", "Width", config.width_px),
        ("height_px", "Height", config.height_px),
    ):
        if size:
            features.write(name, size)
            given = features.number(name)
            if given is not None and round(given) != size:
                raise UserError(
                    f"camera.{key} = {size}: camera {config.device!r} gives {given:g} instead; "
                    "set that, or 0 for its default"
                )
    notes = []
    if not features.write("PixelFormat", "Mono8"):
        notes.append(
            "camera: it does not deliver 8-bit grey images; converting them takes time and bandwidth"
        )
    features.write("ExposureAuto", "Off")
    features.write("GainAuto", "Off")
    if config.exposure_s:
        notes += _set(
            features, _EXPOSURE, config.exposure_s * 1e6, 1e-6, f"exposure_s = {config.exposure_s:g}"
        )
    if config.gain >= 0.0:
        notes += _set(features, _GAIN, config.gain, 1.0, f"gain = {config.gain:g}")
    _set_trigger(features, config)
    if config.frame_rate_hz and config.trigger == "freerun":
        features.write("AcquisitionFrameRateEnable", True)
        notes += _set(features, _RATE, config.frame_rate_hz, 1.0, f"frame_rate_hz = {config.frame_rate_hz:g}")
    return notes


def exposure_s(features: Features) -> float | None:
    """The exposure in use; None if the camera does not report it."""
    for name in _EXPOSURE:
        microseconds = features.number(name)
        if microseconds is not None and microseconds > 0.0:
            return microseconds * 1e-6
    return None


def _set(features: Features, names: tuple[str, ...], value: float, unit: float, key: str) -> list[str]:
    for name in names:
        if features.write(name, value) or features.number(name) is not None:
            given = features.number(name)
            if given is None or abs(given - value) <= _TOLERANCE * abs(value):
                return []
            return [f"camera.{key}: the camera took {given * unit:g} instead; set that, or 0 for its default"]
    return [f"camera.{key}: the camera has no such setting; omit it"]


def _set_trigger(features: Features, config: CameraDevice) -> None:
    features.write("TriggerSelector", "FrameStart")
    if config.trigger == "freerun":
        features.write("TriggerMode", "Off")
        return
    source = "Software" if config.trigger == "software" else "Line1"
    if not (features.write("TriggerMode", "On") and features.write("TriggerSource", source)):
        raise UserError(
            f"camera.trigger = {config.trigger!r}: camera {config.device!r} has no such trigger; use 'freerun'"
        )
