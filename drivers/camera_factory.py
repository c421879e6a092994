"""Opens the camera that a configuration names. Only the named driver and its vendor's package are imported."""

import importlib

from common.configuration import CameraDevice
from drivers.camera import Camera
from drivers.stream_camera import StreamCamera

BACKENDS = {
    "basler": ("drivers.basler_camera", "BaslerBackend"),
    "genicam": ("drivers.genicam_camera", "GenicamBackend"),
    "aravis": ("drivers.aravis_camera", "AravisBackend"),
    "ids_peak": ("drivers.ids_peak_camera", "IdsPeakBackend"),
    "ueye": ("drivers.ueye_camera", "UeyeBackend"),
    "libcamera": ("drivers.libcamera_camera", "LibcameraBackend"),
}


def open_camera(config: CameraDevice, in_flight: int = 1) -> Camera:
    """The camera of section [camera], with `in_flight` images requested ahead. Opens nothing; start() does."""
    if config.driver in BACKENDS:
        module, name = BACKENDS[config.driver]
        backend = getattr(importlib.import_module(module), name)
        return StreamCamera(backend(config), config, in_flight=in_flight)
    if config.driver == "opencv":
        from drivers.opencv_camera import OpenCvCamera

        return OpenCvCamera(config.device, config.width_px, config.height_px, config=config)
    if config.driver == "file":
        from drivers.file_camera import FileCamera

        return FileCamera(config.device)
    from drivers.shared_memory_camera import SharedMemoryCamera

    return SharedMemoryCamera(config.device, in_flight=in_flight)
