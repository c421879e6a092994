"""The factory takes the driver that is named."""

from stillarm.common.files.configuration import CameraDevice
from stillarm.drivers.cameras.camera_factory import open_camera
from stillarm.drivers.cameras.file_camera import FileCamera
from stillarm.drivers.cameras.opencv_camera import OpenCvCamera


def test_factory_takes_the_named_driver(tmp_path):
    assert isinstance(open_camera(CameraDevice(driver="file", device=str(tmp_path))), FileCamera)
    assert isinstance(open_camera(CameraDevice(driver="opencv", device="0")), OpenCvCamera)
