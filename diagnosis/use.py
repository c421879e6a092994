"""What an extended model is worth in use: the controller predicts and damps with it, and with the model as it was.

Both run in virtual time on the same rig, which is the extended model itself, through the same run: a move and a free
ring-down in which predictions are scored, then a ring-down that is damped.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from common.causes import CAUSES
from common.configuration import Configuration
from common.effects import not_used_by_controller
from common.model import EffectValue, Model
from common.recording.topics import EstimateSample, TrueState
from common.scenario import Move, Scenario, Strike, Window
from common.user_error import UserError
from simulation.virtual_time import VirtualRun, simulate

Array = NDArray[np.float64]

_FREE_S, _DAMPED_S, _ON_S, _END_S = 4.5, 9.0, 9.2, 14.0
_FIRST_S, _SEEN_S, _LEFT_AFTER_S = (
    0.5,
    0.5,
    2.0,
)  # a blow is foretold by nobody; it is seen well within half a second
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


def worth_in_use(
    plain: Model, extended: Model, configuration: Configuration, seed: int = 1
) -> dict[str, Any]:
    """`begin_use` and its answer, one run after the other in this process."""
    return begin_use(plain, extended, configuration, seed)()


def begin_use(
    plain: Model,
    extended: Model,
    configuration: Configuration,
    seed: int = 1,
    run_each: Callable[..., Iterable[dict[str, float]]] = map,
) -> Callable[[], dict[str, Any]]:
    """Prediction error and residual vibration with either model: {"before": {...}, "after": {...}, "note"}, when asked.

    run_each: as `map`; an executor's begins both runs at once, in other processes.

    prediction_error_moving_rms, prediction_error_free_rms: rms of estimated less true deflection, from half a second
    after a blow on, while the joint moves and while the arm rings freely; residual_vibration_rms: rms of the true
    deflection from two seconds after the blow that is damped; all over the blow's amplitude of 20 mm.
    Raises UserError where there is nothing to run: no length, or effects that the simulated rig cannot have.
    """
    if extended.arm.length_m is None:
        raise UserError("arm.length_m: needed for a deflection and absent from the model")
    rig = msgspec.structs.replace(extended, effects=[_from_the_start(effect) for effect in extended.effects])
    scores = run_each(partial(_scores, rig, configuration, seed), (plain, extended))

    def answer() -> dict[str, Any]:
        before, after = scores
        return {"before": before, "after": after, "note": not_used_by_controller(extended)}

    return answer


def _from_the_start(effect: dict[str, EffectValue]) -> dict[str, EffectValue]:
    """What began inside the recording has begun long since."""
    known = {parameter.name for parameter in CAUSES[str(effect["cause"])].parameters}
    return {**effect, "onset_s": 0.0} if "onset_s" in known else effect


def _scores(rig: Model, configuration: Configuration, seed: int, assumed: Model) -> dict[str, float]:
    kept = _InMemory()
    simulate(VirtualRun(configuration, rig, assumed, SCENARIO, seed, name="the extended model"), kept, kept)
    truth, said = np.array(kept.truth), np.array(kept.estimates)
    true, estimated = truth[:, 1], np.interp(truth[:, 0], said[:, 0], np.nan_to_num(said[:, 1]))

    def rms(values: Array, start: float, end: float) -> float:
        inside = (truth[:, 0] >= start) & (truth[:, 0] < end)
        return float(np.sqrt(np.mean(values[inside] ** 2))) / _STRUCK_M

    return {
        "prediction_error_moving_rms": rms(estimated - true, _FIRST_S + _SEEN_S, _FREE_S),
        "prediction_error_free_rms": rms(estimated - true, _FREE_S + _SEEN_S, _DAMPED_S),
        "residual_vibration_rms": rms(true, _DAMPED_S + _LEFT_AFTER_S, _END_S),
    }
