"""The table of methods: what `controller.method` and `replay --method` may name."""

import difflib
from collections.abc import Callable

from common.configuration import Controller
from common.model import Model
from common.user_error import UserError
from controller.delay.correlation import CorrelationDelay
from controller.delay.timestamps import TimestampDelay
from controller.estimate import Method
from controller.fused.method import FusedMethod
from controller.sine_method import SineMethod


def _timestamps(model: Model, settings: Controller, model_name: str) -> Method:
    return SineMethod(model, settings.regression, TimestampDelay(model), model_name)


def _correlation(model: Model, settings: Controller, model_name: str) -> Method:
    return SineMethod(model, settings.regression, CorrelationDelay(model, settings.correlation), model_name)


def _fused(model: Model, settings: Controller, model_name: str) -> Method:
    return FusedMethod(model, settings.fused, model_name)


METHODS: dict[str, Callable[[Model, Controller, str], Method]] = {
    "timestamps": _timestamps,
    "correlation": _correlation,
    "fused": _fused,
}


def make_method(name: str, model: Model, settings: Controller, model_name: str) -> Method:
    """The method of that name, fresh. Raises UserError for an unknown one. `model_name` stands for the model file."""
    if name not in METHODS:
        near = difflib.get_close_matches(name, METHODS, n=1, cutoff=0.0)[0]
        raise UserError(f"method {name!r}: unknown; use one of {', '.join(METHODS)} (nearest: {near})")
    return METHODS[name](model, settings, model_name)
