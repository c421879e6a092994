"""The supervisor as a process: the loop around the step, with camera and socket at its edge."""

from pathlib import Path

import cv2
from common.link_key import load_key

from common.configuration import load_configuration
from common.stop_signal import StopSignal
from common.udp import UdpSocket, new_session
from common.visual_sample import TrackingStatus, VisualSample
from drivers.camera import EndOfStream
from drivers.camera_factory import open_camera
from supervisor.exchange import SupervisorExchange
from supervisor.step import Supervisor

_FRAME_TIMEOUT_S = 0.1  # then the controller is told that there is no image
_TIMESTAMPS_AT_ONCE = 256


def run(configuration_path: Path) -> None:
    """Run until SIGTERM or SIGINT, or until a file has no more frames. Raises UserError for what the user can mend."""
    configuration = load_configuration(configuration_path)
    link = configuration.link
    cv2.setNumThreads(1)  # a second thread gains a fifth, and takes a core from the controller
    exchange = SupervisorExchange(load_key(link), new_session(), configuration.supervisor.cycles_in_flight)
    supervisor = Supervisor(configuration.supervisor.tracker)
    camera = open_camera(configuration.camera)
    controller = (link.controller_host, link.controller_port)
    stop = StopSignal()
    socket = UdpSocket((link.supervisor_host, link.supervisor_port), "link.supervisor_port")
    frames = measured = 0
    try:
        camera.start()
        while not stop:
            exchange.take(socket.drain(_TIMESTAMPS_AT_ONCE))
            exchange.begin_cycles()
            try:
                frame = camera.read(_FRAME_TIMEOUT_S)
            except EndOfStream:
                break
            if frame is None:
                exchange.take(socket.drain(_TIMESTAMPS_AT_ONCE))
                sample = VisualSample(-1, exchange.oldest().cycle, TrackingStatus.NO_IMAGE)
            else:
                sample = supervisor.step(frame, exchange.oldest().cycle)
                frames += 1
                measured += sample.measured
            socket.send(exchange.end_cycle(sample), controller)
    finally:
        camera.close()
        socket.close()
    print(
        f"stillarm supervisor: {frames} frames, {measured} measured, {frames - measured} flagged", flush=True
    )
