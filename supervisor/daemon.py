"""The supervisor's process: the loop around the step, with camera, socket and recorder at its edge."""

import time
from pathlib import Path

import cv2

from stillarm.common.datagrams.messages import Timestamp
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Configuration, load_configuration
from stillarm.common.link.link_key import is_loopback, load_key
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.memory.steady_memory import settle_memory
from stillarm.common.process.loop_processor import leave_it_to_the_loop
from stillarm.common.process.priority import raise_priority, run_fifo
from stillarm.common.process.service_notify import Watchdog, notify
from stillarm.common.process.single_instance import hold_instance
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recorder.recorder_client import RECORDING_CUT, RecorderClient
from stillarm.common.recorder.structured_log import log, log_start
from stillarm.common.recording.header import live_header
from stillarm.common.recording.topics import TOPIC_INDEX
from stillarm.drivers.cameras.camera import Camera, EndOfStream, Frame
from stillarm.drivers.cameras.camera_factory import open_camera
from stillarm.supervisor.exchange import SupervisorExchange
from stillarm.supervisor.recorded_images import image_sample
from stillarm.supervisor.start_up import discard_queued, warm_up_recording
from stillarm.supervisor.step import Supervisor
from stillarm.supervisor.tracking.tracker import warm_up
from stillarm.supervisor.view import ViewSender

_NICENESS = -5  # ahead of ordinary programs on this computer
_PRIORITY = 30  # SCHED_FIFO: below the controller's loop, above everything without a deadline
_FRAME_TIMEOUT_S = 0.1  # then the controller is informed that there is no image
_TIMESTAMPS_AT_ONCE = 256
_TIMESTAMPS_EXPECTED = 60  # between two frames
_RING_BYTES = 64 << 20  # holds seconds of images while the disk stalls
_IMAGES = TOPIC_INDEX["/images"]


def run(configuration_path: Path, record_images: Path | None = None) -> None:
    """Run until SIGTERM or SIGINT, or until a file has no more frames. Raises UserError for a user's mistake."""
    configuration = load_configuration(configuration_path)
    hold_instance("supervisor", configuration.link.supervisor_port)
    raise_priority(_NICENESS)
    if is_loopback(configuration.link.controller_host):
        leave_it_to_the_loop()
    cv2.setNumThreads(1)  # a second thread would gain a fifth and take a core from the controller
    # The camera's driver reports in one line, with a remedy, what OpenCV would warn about.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    width, height = configuration.camera.width_px or 640, configuration.camera.height_px or 480
    # before the camera opens, so that no frame waits for it
    warm_up(configuration.supervisor.tracker, width, height)
    camera = open_camera(configuration.camera, configuration.supervisor.cycles_in_flight)
    recorder = None
    if record_images is not None:
        header = live_header(configuration_path, configuration, 0, 0.0)
        warm_up_recording(width, height)
        recorder = RecorderClient.start(
            record_images, header, ring_bytes=_RING_BYTES, process_name="supervisor"
        )
    try:
        loop = _Loop(configuration, camera, recorder)
        try:
            loop.start()
            log_start("supervisor", configuration, configuration_path)
            for note in camera.notes:
                log("supervisor", "warning", note)
            stop = StopSignal()
            settle_memory()
            # a file is read as fast as possible: it has no deadline
            if configuration.camera.driver != "file":
                run_fifo(_PRIORITY)
                loop.begin_fresh()
            loop.run(stop)
        finally:
            notify("STOPPING=1")
            loop.close()
    finally:
        if recorder is not None and not recorder.close():
            log("supervisor", "error", RECORDING_CUT, recording=str(record_images), lost=recorder.lost)
    print(loop.summary(), flush=True)


class _Loop:
    """Takes the timestamp, captures, tracks and sends, once a frame."""

    def __init__(self, configuration: Configuration, camera: Camera, recorder: RecorderClient | None) -> None:
        link = configuration.link
        self._camera = camera
        self._recorder = recorder
        self._supervisor = Supervisor(configuration.supervisor.tracker)
        session = new_session()
        self._exchange = SupervisorExchange(
            load_key(link), session, configuration.supervisor.cycles_in_flight
        )
        self._controller = (link.controller_host, link.controller_port)
        self._socket = UdpSocket((link.supervisor_host, link.supervisor_port), "link.supervisor_port")
        self._socket.guard((Timestamp,), session, _TIMESTAMPS_EXPECTED)
        self._view = ViewSender(configuration.telemetry)
        self._frames = self._measured = self._rounds = 0

    def start(self) -> None:
        """Open the camera. Raises UserError with a remedy, which is all that is printed if the start fails."""
        self._camera.start()

    def begin_fresh(self) -> None:
        """Discard the frames that queued while the camera was opened. Call this last before run()."""
        discard_queued(self._camera)

    def run(self, stop: StopSignal) -> None:
        """Cycle until asked to stop, or until the stream ends."""
        exchange = self._exchange
        notify("READY=1")
        watchdog = Watchdog()
        while not stop:
            self._rounds += 1
            watchdog.feed(self._rounds, time.monotonic())
            self._take_timestamps()
            exchange.begin_cycles()
            try:
                frame = self._camera.read(_FRAME_TIMEOUT_S)
            except EndOfStream:
                return
            if frame is None:
                self._take_timestamps()
                sample = VisualSample(-1, exchange.oldest().cycle, TrackingStatus.NO_IMAGE)
            else:
                sample = self._supervisor.step(frame, exchange.oldest().cycle)
                self._frames += 1
                self._measured += sample.measured
            self._socket.send(exchange.end_cycle(sample, time.monotonic()), self._controller)
            if frame is not None:
                self._record(frame, sample)
                self._view.show(frame.image, self._supervisor.seen_points, sample.frame, time.monotonic())

    def _take_timestamps(self) -> None:
        self._exchange.take(self._socket.drain(_TIMESTAMPS_AT_ONCE), time.monotonic())

    def _record(self, frame: Frame, sample: VisualSample) -> None:
        if self._recorder is not None:
            self._recorder.put(_IMAGES, image_sample(time.monotonic(), frame, sample, self._recorder.lost))

    def close(self) -> None:
        """Release camera and port."""
        self._camera.close()
        self._socket.close()

    def summary(self) -> str:
        """One line about the run."""
        flagged = self._frames - self._measured
        lost = 0 if self._recorder is None else self._recorder.lost
        images = f", {lost} images not recorded" if lost else ""
        return f"stillarm supervisor: {self._frames} frames, {self._measured} measured, {flagged} flagged{images}"
