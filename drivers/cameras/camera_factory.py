"""Opens the camera that a configuration names. Only the named driver and its vendor's package are imported."""

import importlib

from stillarm.common.files.configuration import CameraDevice
from stillarm.drivers.cameras.camera import Camera
from stillarm.drivers.cameras.vendors.stream_camera import StreamCamera

BACKENDS = {
    "basler": ("stillarm.drivers.cameras.vendors.basler_camera", "BaslerBackend"),
    "genicam": ("stillarm.drivers.cameras.vendors.genicam_camera", "GenicamBackend"),
    "aravis": ("stillarm.drivers.cameras.vendors.aravis_camera", "AravisBackend"),
    "ids_peak": ("stillarm.drivers.cameras.vendors.ids_peak_camera", "IdsPeakBackend"),
    "ueye": ("stillarm.drivers.cameras.vendors.ueye_camera", "UeyeBackend"),
    "libcamera": ("stillarm.drivers.cameras.vendors.libcamera_camera", "LibcameraBackend"),
}


def open_camera(config: CameraDevice, in_flight: int = 1) -> Camera:
    """The camera of section [camera], with `in_flight` images requested ahead. Opens nothing; start() does."""
    if config.driver in BACKENDS:
        module, name = BACKENDS[config.driver]
        backend = getattr(importlib.import_module(module), name)
        return StreamCamera(backend(config), config, in_flight=in_flight)
    if config.driver == "opencv":
        from stillarm.drivers.cameras.opencv_camera import OpenCvCamera

        return OpenCvCamera(config.device, config.width_px, config.height_px, config=config)
    if config.driver == "file":
        from stillarm.drivers.cameras.file_camera import FileCamera

        return FileCamera(config.device)
    from stillarm.drivers.cameras.shared_memory_camera import SharedMemoryCamera

    return SharedMemoryCamera(config.device, in_flight=in_flight)
