"""What an extended model is worth in use: the controller predicts and damps with it, and with the model as it was.

Both run in virtual time on the same rig, which is the extended model itself, through the same run: a move and a free
ring-down in which predictions are scored, then a ring-down that is damped. Several such pairs, each with noise of its
own, tell what the difference is worth: a pair's two runs have the same noise.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.effects import not_used_by_controller
from stillarm.common.files.effects_check import EffectValue
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Move, Scenario, Strike, Window
from stillarm.common.recording.topics import EstimateSample, TrueState
from stillarm.common.user_error import UserError
from stillarm.simulation.demo.ring_down import envelope_m, settling_time_s
from stillarm.simulation.virtual_time.virtual_time import VirtualRun, simulate

Array = NDArray[np.float64]


class Measure(NamedTuple):
    """What is scored: its words, the least change that counts, the unit in which it is shown: % of the impact, or s."""

    words: str
    least: float = 1e-3
    unit: str = "%"

    def shown(self, value: float) -> str:
        """The value with its unit."""
        return f"{100.0 * value:.2f} %" if self.unit == "%" else f"{value:.3f} {self.unit}"


MEASURES = {
    "prediction_error_moving_rms": Measure("prediction error while the joint moves, rms"),
    "prediction_error_free_rms": Measure("prediction error while the arm rings freely, rms"),
    "settling_time_s": Measure("settling time, damped, until 5 % of an impact is left", 0.02, "s"),
    "residual_vibration_rms": Measure("vibration left from two seconds after an impact on, damped, rms"),
}
"""What is scored."""


_LEAST_CHANGE = 0.005  # of the value before


_SURE = 2.0  # spreads of the pairs


_FREE_S, _DAMPED_S, _ON_S, _END_S = 4.5, 9.0, 9.2, 14.0


_FIRST_S, _SEEN_S, _LEFT_AFTER_S = (
    0.5,
    0.5,
    2.0,
)  # an impact is foretold by nobody; it is seen well within half a second


_STRUCK_M = 0.02


SCENARIO = Scenario(
    duration_s=_END_S,
    strikes=[Strike(_FIRST_S, _STRUCK_M), Strike(_FREE_S, _STRUCK_M), Strike(_DAMPED_S, _STRUCK_M)],
    moves=[Move(2.0, 2.8, 0.15), Move(3.0, 3.8, -0.15)],
    damping=[Window(_ON_S, _END_S)],
)


class _InMemory:
    """Takes the messages of a run, and keeps what is scored."""

    def __init__(self) -> None:
        """Empty."""
        self.estimates: list[tuple[float, float]] = []
        self.truth: list[tuple[float, float]] = []

    def write(self, topic_name: str, message: msgspec.Struct) -> None:
        """Keep the deflection, estimated and true."""
        if isinstance(message, EstimateSample):
            self.estimates.append((message.time_s, message.deflection_m))
        elif isinstance(message, TrueState):
            self.truth.append((message.time_s, message.deflection_m))


def outcome(use: dict[str, Any], measure: str) -> str:
    """Whether a measure is "better" or "worse" with the extended model: its mean over the pairs changes by twice their
    spread, by half a per cent, and by the least that counts; else "". use: `begin_use`'s answer, of runs made."""
    before, after = use["before"][measure], use["after"][measure]
    spread = use["spread"][measure] if use["spread"] else 0.0
    if abs(after - before) <= max(MEASURES[measure].least, _LEAST_CHANGE * before, _SURE * spread):
        return ""
    return "better" if after < before else "worse"


def worth_in_use(
    plain: Model, extended: Model, configuration: Configuration, seed: int = 1, pairs: int = 1
) -> dict[str, Any]:
    """`begin_use` and its answer, one run after the other in this process."""
    return begin_use(plain, extended, configuration, seed, pairs)()


def begin_use(
    plain: Model,
    extended: Model,
    configuration: Configuration,
    seed: int = 1,
    pairs: int = 1,
    run_each: Callable[..., Iterable[dict[str, float]]] = map,
) -> Callable[[], dict[str, Any]]:
    """Prediction error and residual vibration with either model, when asked: {"before": {...}, "after": {...}: means
    over the pairs; "spread": standard deviation over the pairs of what after is more than before, None of one pair;
    "pairs"; "note"}.

    seed: of the first pair's noise; each later pair has the next. run_each: as `map`; an executor's begins all runs at
    once, in other processes.

    prediction_error_moving_rms, prediction_error_free_rms: rms of estimated less true deflection, from half a second
    after an impact on, while the joint moves and while the arm rings freely; residual_vibration_rms: rms of the true
    deflection from two seconds after the impact that is damped; all over the impact's amplitude of 20 mm.
    settling_time_s: from that impact until the vibration stays below 5 % of it; of one that does not, the time watched.
    Raises UserError where there is nothing to run: no length, or effects that the simulated rig cannot have.
    """
    if extended.arm.length_m is None:
        raise UserError("arm.length_m: needed for a deflection and absent from the model")
    rig = msgspec.structs.replace(extended, effects=[_from_the_start(effect) for effect in extended.effects])
    runs = [(seed + pair, assumed) for pair in range(pairs) for assumed in (plain, extended)]
    scores = run_each(partial(_scores, rig, configuration), runs)

    def answer() -> dict[str, Any]:
        found = list(scores)
        table = np.array([[one[name] for name in MEASURES] for one in found]).reshape(pairs, 2, len(MEASURES))
        before, after = (_by_name(values) for values in table.mean(axis=0))
        spread = _by_name(np.std(table[:, 1] - table[:, 0], axis=0, ddof=1)) if pairs > 1 else None
        note = not_used_by_controller(extended)
        return {"before": before, "after": after, "spread": spread, "pairs": pairs, "note": note}

    return answer


def _by_name(values: Array) -> dict[str, float]:
    return dict(zip(MEASURES, values.tolist(), strict=True))


def _from_the_start(effect: dict[str, EffectValue]) -> dict[str, EffectValue]:
    """What began inside the recording has begun long since."""
    known = {parameter.name for parameter in CAUSES[str(effect["cause"])].parameters}
    return {**effect, "onset_s": 0.0} if "onset_s" in known else effect


def _scores(rig: Model, configuration: Configuration, run: tuple[int, Model]) -> dict[str, float]:
    """run: seed of the noise, and the model that the controller assumes."""
    seed, assumed = run
    kept = _InMemory()
    simulate(VirtualRun(configuration, rig, assumed, SCENARIO, seed, name="the extended model"), kept, kept)
    truth, said = np.array(kept.truth), np.array(kept.estimates)
    true, estimated = truth[:, 1], np.interp(truth[:, 0], said[:, 0], np.nan_to_num(said[:, 1]))
    struck = truth[:, 0] > _DAMPED_S
    step_s = float(truth[1, 0] - truth[0, 0])
    envelope = envelope_m(true[struck], step_s, rig.arm.modes[0].frequency_hz)
    settled_s = settling_time_s(envelope, step_s, _STRUCK_M)

    def rms(values: Array, start: float, end: float) -> float:
        inside = (truth[:, 0] >= start) & (truth[:, 0] < end)
        return float(np.sqrt(np.mean(values[inside] ** 2))) / _STRUCK_M

    return {
        "prediction_error_moving_rms": rms(estimated - true, _FIRST_S + _SEEN_S, _FREE_S),
        "prediction_error_free_rms": rms(estimated - true, _FREE_S + _SEEN_S, _DAMPED_S),
        "settling_time_s": _END_S - _DAMPED_S if settled_s is None else settled_s,
        "residual_vibration_rms": rms(true, _DAMPED_S + _LEFT_AFTER_S, _END_S),
    }
