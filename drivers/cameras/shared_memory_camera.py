"""A camera whose frames come from another process, through a ring of images in shared memory."""

import time
from collections.abc import Callable

from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame
from stillarm.drivers.cameras.frame_ring import FrameRingReader

_POLL_S = 0.0004
_LOOK_FOR_RESTART_S = 0.1  # checking the file system is costlier than checking the ring
_TOO_FAR_BEHIND = 3  # frames: fewer may arrive together by chance
ASK_AGAIN_S = 1.0  # a request without an answer for this time counts as lost


class SharedMemoryCamera:
    """Frames from another process; implements stillarm.drivers.cameras.camera.Camera.

    If the provider restarts, its new ring is opened as soon as it exists, and read from its first frame on. While the
    provider is absent or stalled, read() times out. A triggered provider gets one request for each frame taken, so that
    `in_flight` requests are always open.
    """

    def __init__(
        self,
        name: str,
        *,
        in_flight: int = 1,
        wait_s: float = 10.0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Read the ring `name`; start() waits up to `wait_s` for it. Opens nothing yet."""
        self._name = name
        self._in_flight = in_flight
        self._wait_s = wait_s
        self._clock = clock
        self._sleep = sleep
        self._ring: FrameRingReader | None = None
        self._started = False
        self._look_at_s = 0.0
        self._last_frame_s = 0.0
        self._lost_before = 0
        self.notes: list[str] = []

    @property
    def lost(self) -> int:
        """Number of frames that were overwritten before they were read."""
        return self._lost_before + (self._ring.lost if self._ring is not None else 0)

    def start(self) -> None:
        """Open the ring and skip the frames already in it. Raises UserError if it does not appear."""
        try:
            ring = FrameRingReader(self._name, wait_s=self._wait_s, from_newest=True)
        except UserError:
            raise UserError(
                f"camera.device = {self._name!r}: no process offered frames under this name within "
                f"{self._wait_s:g} s; start it (the simulated rig: `stillarm rig`), or correct camera.device"
            ) from None
        self._use(ring)
        self._started = True

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame in order; None if none arrived within `timeout_s`. Its image is valid until the next call."""
        if not self._started:
            raise RuntimeError("read() before start()")
        deadline = self._clock() + timeout_s
        while True:
            frame, passed = self._take()
            now = self._clock()
            if frame is not None and self._ring is not None:
                self._last_frame_s = now
                self._ring.request(1 + passed)
                return frame
            if now >= self._look_at_s:
                self._look_at_s = now + _LOOK_FOR_RESTART_S
                self._reopen_if_replaced()
            if self._ring is not None and now >= self._last_frame_s + ASK_AGAIN_S:
                self._last_frame_s = now
                self._ring.request(self._in_flight)
            if now >= deadline:
                return None
            self._sleep(min(_POLL_S, deadline - now))

    def _take(self) -> tuple[Frame | None, int]:
        """The next frame, and the number of skipped frames: a consumer that is behind continues with the newest."""
        ring = self._ring
        if ring is None:
            return None, 0
        behind = ring.waiting - 1
        passed = behind if behind >= _TOO_FAR_BEHIND else 0
        ring.pass_over(passed)
        return ring.take(), passed

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._started = False
        self._drop()

    def _reopen_if_replaced(self) -> None:
        if self._ring is not None and self._ring.replaced():
            self._drop()
        if self._ring is None:
            try:
                self._use(FrameRingReader(self._name))
            except UserError:  # still absent: the read times out, and checks again later
                return

    def _use(self, ring: FrameRingReader) -> None:
        self._ring = ring
        self._last_frame_s = self._clock()
        ring.request(self._in_flight)

    def _drop(self) -> None:
        if self._ring is not None:
            self._lost_before += self._ring.lost
            self._ring.close()
            self._ring = None
