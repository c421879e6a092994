"""Where a fit with play in the gear may begin: which sensor is on which side, how heavy the motor, how wide the gap."""

from collections.abc import Iterator

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit

_SHARES = (0.15, 0.35, 0.65)  # of the motor in the inertia of motor and hub
BOUNCE = 0.3  # of the velocity at which teeth meet: steel on steel with oil between
HARD_PLAY = ("gap", "share", "bounce")
_GAPS = (0.001, 0.02, 0.25)  # of the angle's deviation: no small gap leads to a wide one, nor the other way


def gaps(fitted: DrivenFit) -> Iterator[dict[str, float]]:
    """On either side of the play sits each sensor that is not the motor's by its name: a velocity is often told by the
    motor where the angle is the link's."""
    travel = float(np.std(fitted.run.states[:, 0])) + 1e-12
    kinds = [one.kind for one in fitted.box.driven.outputs]
    sides = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
    if "velocity" not in kinds or not {"position", "motor"} & set(kinds):
        sides = [(0.0, 0.0), (1.0, 1.0)]
    if not {"position", "velocity"} & set(kinds):
        sides = [(0.0, 0.0)]
    for angle, rate in sides:
        for share in _SHARES:
            for gap in _GAPS:
                yield {
                    "gap": gap * travel,
                    "share": share,
                    "on_motor": angle,
                    "rate_on_motor": rate,
                }
