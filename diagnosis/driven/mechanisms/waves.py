"""Which waves over the joint's angle a torque ripple may have: what the outputs lack, as each wave would have made it.

The measured acceleration shows a quick wave badly: two differences amplify the sensor's noise, and a window against
that takes the wave away too. Here each wave's force goes through the linear model to every output instead, and is
regressed on what the fit leaves there, block by block, without what a block's initial state can make (a line and a
bow), and without what gain, damping and dry friction would.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, ifft, prev_fast_len

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, levels_of_fit
from stillarm.diagnosis.driven.greybox.laws import Numbers
from stillarm.diagnosis.driven.recording.regression import joint_motion

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_FEWEST_PERIODS, _MOST_PERIODS = 1.25, 160.0
"""Over the travel: about one is a slope or a bow, as of gravity or a cable."""
_APART = 0.25  # periods, between two that are tried
_STRONGEST = 3  # that are fitted, of all peaks
_MOST_SAMPLES = 16_000  # every second one, and so on, of more: what a wave over them costs
_TAKEN_AWAY = 3  # powers of time, of each block
_BLOCKS = 15  # without what an initial state makes: as many as blocks.py has of a long recording
_STILL = 0.02  # of the largest velocity: below that friction turns over


@dataclass(frozen=True)
class Wave:
    """cycles: of sine and cosine of `cycles * theta`, 1/rad; rad/s^2."""

    cycles: float
    sine: float
    cosine: float


def strongest_waves(fitted: DrivenFit) -> list[Wave]:
    """The waves over the angle that explain most of what is left, the best first; none where no sensor shows it."""
    motion = joint_motion(fitted.box.driven, numbers=fitted.numbers)
    if motion is None:
        return []
    travel = float(np.ptp(motion[0]))
    if travel <= 0.0:
        return []
    many = max(1, len(motion[0]) // _MOST_SAMPLES)
    samples = int(prev_fast_len(len(motion[0][::many])))
    theta, omega, drive = (one[::many][:samples] for one in (*motion[:2], fitted.run.drive))
    sensors = _Sensors.of(fitted, samples, many)
    turning = np.tanh(omega / max(_STILL * float(np.max(np.abs(omega))), 1e-12))
    other = np.column_stack(
        [sensors.without_bows(sensors.made_by(one).real) for one in (drive, omega, turning)]
    )
    plain = np.linalg.qr(other / np.linalg.norm(other, axis=0))[0].T
    left = sensors.without_bows(np.asarray(sensors.blocks(sensors.left), np.float64))
    left -= (plain @ left) @ plain
    tried = np.arange(_FEWEST_PERIODS, _MOST_PERIODS, _APART) * 2.0 * np.pi / travel
    wave, further = np.exp(1j * tried[0] * theta), np.exp(1j * (tried[1] - tried[0]) * theta)
    share, found = np.zeros(len(tried)), []
    for k, cycles in enumerate(tried):
        normal, moment = _equations(sensors, wave, plain, left)
        factor = np.linalg.lstsq(normal, moment, rcond=1e-9)[0]
        share[k] = float(factor @ moment)
        found.append(Wave(float(cycles), float(factor[0]), float(factor[1])))
        wave *= further
    peaks = [k for k in range(1, len(tried) - 1) if share[k] >= share[k - 1] and share[k] > share[k + 1]]
    return [found[k] for k in sorted(peaks, key=lambda k: -share[k])[:_STRONGEST]]


def _equations(sensors: "_Sensors", wave: Complex, plain: Array, left: Array) -> tuple[Array, Array]:
    """Normal matrix (2, 2) and moment (2,) of a wave's sine and cosine, without bows and what is plain: what these hold
    of it is taken off the sums of squares, as they are orthonormal."""
    made = sensors.made_by(wave)
    flat = made.ravel()
    held = np.concatenate([(made @ sensors.bows).ravel(), plain @ flat])
    size = float(np.vdot(flat, flat).real - np.vdot(held, held).real)
    turned = complex(flat @ flat - held @ held)
    normal = np.array([[size - turned.real, turned.imag], [turned.imag, size + turned.real]]) / 2.0
    moment = complex(left @ flat)
    return normal, np.array([moment.imag, moment.real])


@dataclass(frozen=True)
class _Sensors:
    """answers: (outputs, n) to a force on the joint, by frequency, in deviations. left: (outputs, n) of the residual.
    bows: (length, powers of time), orthonormal over a block."""

    answers: Complex
    left: Array
    bows: Array

    @classmethod
    def of(cls, fitted: DrivenFit, samples: int, many: int) -> "_Sensors":
        """Of every so many samples."""
        sigma = levels_of_fit(fitted)
        answers = _answers(fitted, samples, many * fitted.box.driven.step_s)
        left = [np.nan_to_num(fitted.residuals[name][::many][:samples]) / sigma[name] for name in answers]
        told = [one / sigma[name] for name, one in answers.items()]
        bows = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, samples // _BLOCKS), _TAKEN_AWAY))[0]
        return cls(np.array(told), np.array(left), bows)

    def made_by(self, force: Array | Complex) -> Complex:
        """What the sensors show of a force, (outputs, blocks, length)."""
        return np.asarray(self.blocks(ifft(self.answers * fft(force), axis=1)), np.complex128)

    def blocks(self, values: Array | Complex) -> Array | Complex:
        """Samples by blocks."""
        length = len(self.bows)
        return values[:, : length * _BLOCKS].reshape(len(values), _BLOCKS, length)

    def without_bows(self, blocks: Array) -> Array:
        """All samples, each block without its mean, slope and bow."""
        return np.asarray((blocks - (blocks @ self.bows) @ self.bows.T).ravel())


def _answers(fitted: DrivenFit, samples: int, step_s: float) -> dict[str, Complex]:
    """By output, its answer to a force on the joint at the frequencies of a Fourier transform."""
    box, numbers = fitted.box, fitted.numbers
    a, b = box.linear(numbers).equations()
    s = np.asarray(2j * np.pi * np.fft.fftfreq(samples, step_s), np.complex128)
    s[0] = s[1]
    state = np.linalg.solve(
        s[:, None, None] * np.eye(len(a)) - a, np.broadcast_to(b[:, 1:2], (samples, len(a), 1))
    )
    z = np.asarray(state[:, :, 0], np.complex128)
    answers = {}
    for one in box.driven.outputs:
        answer = _seen(one.kind, one.name, numbers, z, s) * numbers.get(f"scale {one.name}", 1.0)
        answer[0] = 0.0
        answers[one.name] = answer
    return answers


def _seen(kind: str, name: str, numbers: Numbers, z: Complex, s: Complex) -> Complex:
    modes = range(1, z.shape[1] // 2)
    if kind in ("position", "motor"):
        return z[:, 0].copy()
    if kind == "velocity":
        return z[:, 1].copy()
    if kind == "deflection":
        return np.asarray(sum(z[:, 2 * i] for i in modes) + 0.0 * s)
    bent = sum(numbers.get(f"share_{i} {name}", 1.0) * s * z[:, 2 * i + 1] for i in modes)
    return np.asarray(numbers.get(f"direct {name}", 0.0) * s * z[:, 1] + bent)
