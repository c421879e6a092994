"""What the sensors show of a jump of a linear mode: the same for every impact, from the cycle of that impact on.

Sensors that answer linearly, and alike at all times, make a derivative by a jump the one of any other impact, moved in
time: it is worked out once for each mode, not once for each impact.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.physics.accelerometer import Accelerometer
from stillarm.diagnosis.physics.arm_motion import ArmMotion
from stillarm.diagnosis.physics.camera import Camera
from stillarm.diagnosis.physics.computing import Lately

Array = NDArray[np.float64]

_REST = 4  # cycles before the jump: an interpolation between samples reaches two of them back


@dataclass(frozen=True)
class _Answer:
    """To a jump after `rest` cycles at rest, (rest + cycles,), a unit of it. deflection: m; acceleration: as the
    accelerometer shows it, m/s^2; scene: what the camera looks at, px. None: of a sensor that tells no two impacts
    alike."""

    rest: int
    deflection: Array
    acceleration: Array | None
    scene: Array | None


class JumpAnswers:
    """Derivatives of a recording's channels by the jumps of its impacts."""

    def __init__(self, arm: ArmMotion, accelerometer: Accelerometer, camera: Camera, answers: int) -> None:
        """answers: that are remembered, two for each mode."""
        self._arm, self._accelerometer, self._camera = arm, accelerometer, camera
        self._answers: Lately[tuple[int, bool, bytes], _Answer] = Lately(answers)

    def forget(self) -> None:
        """Give the memory of what is remembered back."""
        self._answers.forget()

    def slopes(self, place: int, vector: Array, shown: dict[str, Array]) -> dict[str, Array] | None:
        """Derivative of each channel that an impact's jump moves, (samples,), by the quantity at that place of the
        vector; None for any other quantity, and where no other impact's would do. shown: what the vector makes of each
        channel."""
        jump = self._arm.jump_at(place, vector)
        if jump is None:
            return None
        cycle, mode, velocity = jump
        if cycle < _REST:
            return None  # an interpolation at the recording's first samples is another
        key = (mode, velocity, vector.tobytes())
        one = self._answers.of(key, lambda: self._answer(mode, velocity, vector))
        found: dict[str, Array] = {}
        if "deflection" in shown:
            found["deflection"] = _from(cycle, one.rest, one.deflection)
        if "acceleration" in shown:
            if one.acceleration is None:
                return None
            within = self._accelerometer.is_within_limits(shown["acceleration"], vector)
            found["acceleration"] = np.where(within, _from(cycle, one.rest, one.acceleration), 0.0)
        if "displacement" in shown:
            if one.scene is None:
                return None
            begins, ends = max(one.rest - cycle, 0), len(one.scene) - cycle  # where the recording does
            later = cycle - one.rest + begins
            found["displacement"] = self._camera.exposed_later(one.scene[begins:ends], later, vector)
        return found

    def _answer(self, mode: int, velocity: bool, vector: Array) -> _Answer:
        decay, slope_per_m = self._arm.decay_of(mode, vector)
        rest = _REST + self._camera.exposed_cycles
        q, qdd = (np.concatenate((np.zeros(rest), decay[:, 2 * velocity + which])) for which in (0, 1))
        return _Answer(
            rest,
            q,
            self._accelerometer.answer(qdd, vector),
            self._camera.scene_of(q, slope_per_m * q, vector),
        )


def _from(cycle: int, rest: int, answer: Array) -> Array:
    """An answer that begins after `rest` samples, from a cycle on. Just before it is what an interpolation between
    samples makes of it."""
    later, before = np.zeros(len(answer) - rest), min(cycle, rest)
    later[cycle - before :] = answer[rest - before : len(answer) - cycle]
    return later
