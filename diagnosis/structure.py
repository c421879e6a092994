"""What is left of the channels: whether terms without a name, memory, or uneven scatter predict what is held out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.anonymous import Explained, explained
from stillarm.diagnosis.fit import Data, Fit
from stillarm.diagnosis.noise import InstantUncertainty
from stillarm.diagnosis.scatter import Uneven, uneven
from stillarm.diagnosis.unpredictable import unpredictable

Array = NDArray[np.float64]

_LEAST_HELD_NATS, _LEAST_TRAIN_NATS = 8.0, 12.0
_IN_DOUBT = 2.0  # times the image's noise at rest, once scaled by what the instants' doubt is worth


@dataclass(frozen=True)
class Structure:
    """What is known of a channel's residual. white: no law predicts anything of its held-out part.

    nats: what the best law gains there, std_nats its standard error over blocks, train_nats on the training part.
    band_hz: where most of the excess power lies. dependence: that law, in words; term: amounts, if it is of terms.
    """

    channel: str
    white: bool
    nats: float
    std_nats: float
    train_log_likelihood: float
    band_hz: tuple[float, float]
    dependence: str
    term: str


@dataclass(frozen=True)
class Remains:
    """Structure of each channel, and what terms without a name explain of all of them."""

    channels: dict[str, Structure]
    terms: Explained

    @property
    def left(self) -> dict[str, float]:
        """Nats that are left of the training part, by each channel in which something can be predicted."""
        return {name: one.train_log_likelihood for name, one in self.channels.items() if not one.white}

    @property
    def worst(self) -> Structure | None:
        """The channel in which most can be predicted, if any."""
        found = [one for one in self.channels.values() if not one.white]
        return max(found, key=lambda one: one.nats, default=None)


def examine(data: Data, last: Fit, known_laws: frozenset[str] = frozenset()) -> Remains:
    """Look at a fit's residuals. known_laws: causes among the findings that are laws of noise or timing."""
    terms = explained(data, last)
    # when a gear strikes is known to a cycle or two, and shows in one sample
    laws = uneven(data, last, "impulse_noise" in known_laws or last.value("drive.gap_rad") > 0.0)
    excused = {"arrival"} if "delay_bursts" in known_laws else set()
    held = data.split.held if data.split.held.any() else ~data.split.held
    held = held & ~unpredictable(data, last)
    by_terms = _of_terms(terms, last)
    found = {}
    for name in last.residuals:
        choices = [
            _Choice(one.law, "", one.train_log_likelihood, one.block_nats if one.everywhere else one.block_nats[held],
                    float(held.mean()) if one.everywhere else 1.0)
            for one in laws
            if one.channel == name
            and not (name in excused or _dated_by_arrival(one, last) or _within_its_spread(one, last))
        ]  # fmt: skip
        if by_terms == name:
            choices.append(
                _Choice(terms.names[0], _words(terms), terms.train_log_likelihood, terms.block_nats[held])
            )
        found[name] = _best(name, choices, last)
    return Remains(found, terms)


def _dated_by_arrival(one: Uneven, last: Fit) -> bool:
    """An image dated by its arrival is off by its speed times the delay's scatter: that is no discovery, as long as the
    scatter that the delay is known to have explains it."""
    if one.channel != "displacement" or not last.world.frame_clock.arrival:
        return False
    images = last.channel("displacement")
    if images is None or not isinstance(images.colour, InstantUncertainty):
        return True
    return images.sigma < _IN_DOUBT * images.colour.noise_px


def _within_its_spread(one: Uneven, last: Fit) -> bool:
    """Whether arrivals scatter unevenly, as a busy computer makes them, or each as the one before it, as in a queue in
    which none overtakes another, but at their worst by no more than the model states: nothing that it says of the delay
    is wrong then, as of one that wanders within its spread."""
    stated_s = last.world.model.timing.capture_delay_std_s
    return one.channel == "arrival" and one.most * last.sigma[one.channel] < stated_s


def _of_terms(terms: Explained, last: Fit) -> str:
    """The channel that the terms are told of: forces on the arm by the one that shows them best."""
    if terms.channel != "arm":
        return terms.channel
    return next(
        (name for name in ("acceleration", "deflection", "displacement") if name in last.residuals), ""
    )


@dataclass(frozen=True)
class _Choice:
    """A law or terms. train_nats: gained on the training part; gains: of each block that judges; held: which share of
    these nats is counted as held out, so that they compare with a finding's (the rest being the training part's).
    """

    law: str
    term: str
    train_log_likelihood: float
    gains: Array
    held: float = 1.0


def _best(name: str, choices: list[_Choice], last: Fit) -> Structure:
    band = _band(last, name)
    best = Structure(name, True, 0.0, 0.0, 0.0, band, "none found", "")
    for one in choices:
        total = float(one.gains.sum())
        spread = float(np.std(one.gains) * len(one.gains) ** 0.5)
        sure = one.train_log_likelihood > _LEAST_TRAIN_NATS and total > max(_LEAST_HELD_NATS, spread)
        if sure and one.held * total > best.nats:
            train = one.train_log_likelihood if one.held == 1.0 else (1.0 - one.held) * total
            best = Structure(name, False, one.held * total, one.held * spread, train, band, one.law, one.term)
    return best


def _words(terms: Explained) -> str:
    return " + ".join(
        f"{amount:.3g} x ({name})" for name, amount in zip(terms.names, terms.amounts, strict=True)
    )


def _band(last: Fit, name: str) -> tuple[float, float]:
    """Band, Hz, that holds the middle four fifths of the power above the median level."""
    world = last.world
    step = world.step_s(name)
    residual = np.nan_to_num(last.residuals[name] / last.sigma[name])
    n = min(len(residual), 4096)
    count = max(1, len(residual) // n)
    pieces = residual[: n * count].reshape(count, n) * np.hanning(n)
    power = np.mean(np.abs(np.fft.rfft(pieces, axis=1)) ** 2, axis=0)[1:]
    hz = np.fft.rfftfreq(n, step)[1:]
    excess = np.clip(power - 1.5 * np.median(power), 0.0, None)
    if excess.sum() <= 0.0:
        return (float(hz[0]), float(hz[-1]))
    share = np.cumsum(excess) / excess.sum()
    return (
        float(hz[np.searchsorted(share, 0.1)]),
        float(hz[min(int(np.searchsorted(share, 0.9)), len(hz) - 1)]),
    )
