"""The causes that change the arm's frequencies while it runs: a payload taken up or put down, a drifting stiffness."""

from common.effects import effect_of, effects_of
from common.model import Model
from common.user_error import UserError

_LOWEST = 0.01  # of the first frequency as declared: an arm that has lost its stiffness is no longer one


class FrequencyChange:
    """ratio(t) = (1 + rate t / f_1) times the ratio of every payload change whose onset has passed, for the first mode;
    for each other mode the same with higher_modes_share of every change. Damping ratios stay, deflections and rates are
    continuous.
    """

    def __init__(self, model: Model) -> None:
        """As the model's effects name them."""
        self._payloads = [
            (p["onset_s"], p["frequency_ratio"], p["higher_modes_share"])
            for p in effects_of(model, "payload_change")
        ]
        drift = effect_of(model, "stiffness_drift")
        self._relative_per_s = (
            drift["frequency_rate_hz_per_s"] / model.arm.modes[0].frequency_hz if drift else 0.0
        )
        self._drift_share = drift["higher_modes_share"] if drift else 1.0
        self.happens = bool(self._payloads) or self._relative_per_s != 0.0

    def ratios(self, time_s: float) -> tuple[float, float]:
        """The first mode's frequency over the declared one, and every other's, at a time from the recording's start.

        Raises UserError when the drift has taken the stiffness away.
        """
        ratio = 1.0 + self._relative_per_s * time_s
        if ratio < _LOWEST:
            raise UserError(
                f"effects: stiffness_drift: at {time_s:.3f} s nothing is left of the arm's stiffness; "
                "take a smaller frequency_rate_hz_per_s, or a shorter run"
            )
        others = 1.0 + self._drift_share * (ratio - 1.0)
        for onset_s, changed, share in self._payloads:
            if time_s >= onset_s:
                ratio *= changed
                others *= 1.0 + share * (changed - 1.0)
        return ratio, max(others, _LOWEST)
