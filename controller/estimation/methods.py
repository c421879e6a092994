"""The table of methods for `controller.method` and `replay --method`: our own, then those of installed packages."""

import difflib
from collections.abc import Callable

from stillarm.common.files.configuration import Controller
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.delay.constant import ConstantDelay
from stillarm.controller.estimation.delay.correlation import CorrelationDelay
from stillarm.controller.estimation.delay.timestamps import TimestampDelay
from stillarm.controller.estimation.estimate import Method
from stillarm.controller.estimation.fused.method import FusedMethod
from stillarm.controller.estimation.installed_methods import (
    MethodFactory,
    installed_factory,
    installed_methods,
)
from stillarm.controller.estimation.kalman.fast_sensor import AccelerometerReading, StrainGaugeReading
from stillarm.controller.estimation.kalman.kalman_method import KalmanMethod
from stillarm.controller.estimation.sine_method import DelayEstimator, SineMethod


def _timestamps(model: Model, settings: Controller, model_name: str) -> Method:
    return SineMethod(model, settings.regression, TimestampDelay(model), model_name)


def _correlation(model: Model, settings: Controller, model_name: str) -> Method:
    return SineMethod(model, settings.regression, CorrelationDelay(model, settings.correlation), model_name)


def _fused(model: Model, settings: Controller, model_name: str) -> Method:
    return FusedMethod(model, settings.fused, model_name)


def _kalman_constant_delay(model: Model, settings: Controller, model_name: str) -> Method:
    return KalmanMethod(model, settings.kalman, ConstantDelay(model), model_name)


def _kalman_variable_delay(model: Model, settings: Controller, model_name: str) -> Method:
    return KalmanMethod(model, settings.kalman, TimestampDelay(model), model_name)


def _kalman_fusion(model: Model, settings: Controller, model_name: str) -> Method:
    kalman = settings.kalman
    delay = TimestampDelay(model) if kalman.fusion_delay == "timestamps" else ConstantDelay(model)
    gauge = kalman.fusion_sensor == "strain_gauge"
    reading = StrainGaugeReading(kalman.strain_noise_m) if gauge else AccelerometerReading(model)
    return KalmanMethod(model, kalman, delay, model_name, reading)


METHODS: dict[str, MethodFactory] = {
    "timestamps": _timestamps,
    "correlation": _correlation,
    "kalman_constant_delay": _kalman_constant_delay,
    "kalman_variable_delay": _kalman_variable_delay,
    "kalman_fusion": _kalman_fusion,
    "fused": _fused,
}


def all_methods() -> tuple[str, ...]:
    """Names of our methods, then of those that installed packages add. Imports none of them."""
    return (*METHODS, *(name for name in installed_methods() if name not in METHODS))


def check_method(name: str) -> None:
    """Raise UserError for a name that no method has."""
    if name not in METHODS and name not in installed_methods():
        near = difflib.get_close_matches(name, all_methods(), n=1, cutoff=0.0)[0]
        raise UserError(f"method {name!r}: unknown; use one of {', '.join(all_methods())} (nearest: {near})")


def make_method(name: str, model: Model, settings: Controller, model_name: str) -> Method:
    """A new method by name. Raises UserError for an unknown one. model_name: name of the model file, for messages.

    Our own names take precedence over installed packages. Installed packages are looked through only for other names.
    """
    if name in METHODS:
        return METHODS[name](model, settings, model_name)
    check_method(name)
    return installed_factory(name)(model, settings, model_name)


def with_sine_prediction(make_delay: Callable[[Model], DelayEstimator]) -> MethodFactory:
    """A method out of a delay estimator alone: the paper's sine regression predicts from the images that it dates.

    make_delay: called with the model, once for each start of the method.
    """

    def factory(model: Model, settings: Controller, model_name: str) -> Method:
        return SineMethod(model, settings.regression, make_delay(model), model_name)

    return factory


__all__ = ["METHODS", "MethodFactory", "all_methods", "check_method", "make_method", "with_sine_prediction"]
