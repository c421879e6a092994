"""Which waves over the joint's angle a torque ripple may have: what the outputs lack, as each wave would have made it.

The measured acceleration shows a quick wave badly: two differences amplify the sensor's noise, and a window against
that takes the wave away too. Here each wave's force goes through the linear model to every output instead, and is
regressed on what the fit leaves there, block by block, without what a block's initial state can make (a line and a
bow), and without what gain, damping and dry friction would.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting import DrivenFit, levels_of_fit
from stillarm.diagnosis.driven.laws import Numbers
from stillarm.diagnosis.driven.regression import joint_motion

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
    motion = joint_motion(fitted.box.driven)
    if motion is None:
        return []
    travel = float(np.ptp(motion[0]))
    if travel <= 0.0:
        return []
    many = max(1, len(motion[0]) // _MOST_SAMPLES)
    theta, omega = motion[0][::many], motion[1][::many]
    answers = _answers(fitted, len(theta), many * fitted.box.driven.step_s)
    sigma = levels_of_fit(fitted)
    left = np.concatenate(
        [_without_bows(np.nan_to_num(fitted.residuals[name][::many]) / sigma[name]) for name in answers]
    ).real

    def made_by(force: Array | Complex) -> Complex:
        spectrum = np.fft.fft(force)
        made = [_without_bows(np.fft.ifft(one * spectrum) / sigma[name]) for name, one in answers.items()]
        return np.concatenate(made)

    turning = np.tanh(omega / max(_STILL * float(np.max(np.abs(omega))), 1e-12))
    other = np.column_stack([made_by(one).real for one in (fitted.run.drive[::many], omega, turning)])
    plain, _ = np.linalg.qr(other / np.linalg.norm(other, axis=0))
    left -= plain @ (plain.T @ left)
    tried = np.arange(_FEWEST_PERIODS, _MOST_PERIODS, _APART) * 2.0 * np.pi / travel
    share, found = np.zeros(len(tried)), []
    for k, cycles in enumerate(tried):
        whole = made_by(np.exp(1j * cycles * theta))
        columns = np.column_stack([whole.imag, whole.real])
        columns -= plain @ (plain.T @ columns)
        normal, moment = columns.T @ columns, columns.T @ left
        factor = np.linalg.lstsq(normal, moment, rcond=1e-9)[0]
        share[k] = float(factor @ moment)
        found.append(Wave(float(cycles), float(factor[0]), float(factor[1])))
    peaks = [k for k in range(1, len(tried) - 1) if share[k] >= share[k - 1] and share[k] > share[k + 1]]
    return [found[k] for k in sorted(peaks, key=lambda k: -share[k])[:_STRONGEST]]


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


def _without_bows(values: Array | Complex) -> Complex:
    """Each block without its mean, slope and bow."""
    length = len(values) // _BLOCKS
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), _TAKEN_AWAY))
    blocks = values[: length * _BLOCKS].reshape(_BLOCKS, length)
    flat = blocks - (blocks @ basis) @ basis.T
    return np.asarray(flat.ravel(), np.complex128)
