"""The camera that a configuration names. Only the named driver is imported."""

from common.configuration import CameraDevice
from drivers.camera import Camera


def open_camera(config: CameraDevice, in_flight: int = 1) -> Camera:
    """The camera of section [camera], with `in_flight` images asked for ahead. Opens nothing yet:
    start() does.
    """
    if config.driver == "opencv":
        from drivers.opencv_camera import OpenCvCamera

        return OpenCvCamera(config.device, config.width_px, config.height_px)
    if config.driver == "file":
        from drivers.file_camera import FileCamera

        return FileCamera(config.device)
    from drivers.shared_memory_camera import SharedMemoryCamera

    return SharedMemoryCamera(config.device, in_flight=in_flight)
