"""Damping with the joint: a velocity proportional to the predicted deflection.

With theta'' = k q', q'' + 2 zeta w q' + w^2 q = -p L theta'' becomes q'' + (2 zeta w + p L k) q' + w^2 q = 0: a joint
velocity k q adds the damping ratio p L k / (2 w), for either sign of the participation p, and a little more if it
trails q. docs/damping.md derives it, with the slow return to the commanded position that prevents an offset from
making the joint creep. The law "composite" (composite.py) adds the rate to the fast part, and uses the image for the
slow part.
"""

from enum import StrEnum
from math import isfinite
from typing import NamedTuple

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Damping
from stillarm.common.files.effects import effect_of
from stillarm.common.files.model import Model, length_of
from stillarm.controller.command.composite import CompositeControl
from stillarm.controller.estimation.estimate import Estimate, Status
from stillarm.controller.joint.drive_model import STEPWISE_CYCLES, DriveModel, drive_lead_s
from stillarm.controller.joint.gear_play import GearPlay, PlayCrossing
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.safety.health import DRIVE_SILENT_S

_ENTRY_S = 0.2  # from no damping to full damping
# Damping fades in if the prediction's standard deviation, without the delay's contribution, is at most this fraction of
# the vibration's amplitude, or commands at most this fraction of the drive's velocity. A fit to a quarter of a period
# with unknown zero claims several times the actual vibration, at four or five times its own deviation.
_SURE_OF_AMPLITUDE, _SURE_OF_DRIVE = 0.15, 0.002


def most_damping_lag_s(damping_ratio: float, angular_frequency: float) -> float:
    """The lag of the joint that damps most, for a total damping ratio up to 0.4; docs/damping.md."""
    return 2.0 * damping_ratio / (1.0 + 4.0 * damping_ratio * damping_ratio) / angular_frequency


class _Law(NamedTuple):
    """What follows from the added damping ratio. gain: rad/s per metre; lead_s: how far ahead the joint follows."""

    gain: float
    lead_s: float
    composite: CompositeControl | None


class DampingStatus(StrEnum):
    """Why the joint damps, or does not."""

    OFF = "off"  # not allowed by the operator, or by the schedule
    ACTIVE = "active"
    VISION_STALE = "vision stale"
    NO_PREDICTION = "no prediction"
    DRIVE_SILENT = "drive silent"


class JointDamping:
    """The damping part of the command. Zero whenever its inputs are stale, absent or not finite."""

    def __init__(self, model: Model, settings: Damping, model_name: str) -> None:
        """Damp the first mode of `model` by `settings.added_damping_ratio`."""
        mode = model.arm.modes[0]
        w = mode.angular_frequency
        self._settings = settings
        self._cycle_s = model.timing.cycle_s
        self._w = w
        self._model, self._length = model, length_of(model, model_name)
        self._sure_rad_s = _SURE_OF_DRIVE * model.drive.max_velocity_rad_s
        self._decay = 2.0 * mode.damping_ratio * w
        self._weight = 0.0
        self._next_law: _Law | None = None
        self.at_limit = False
        """Whether the last returned value was limited to settings.max_velocity_rad_s."""
        self._last_measured_s = float("-inf")
        self._commanded = DriveModel(model.drive, model.timing.cycle_s)
        self._anchored = False
        play = effect_of(model, "gear_backlash")
        self._crossing = (
            PlayCrossing(play["gap_rad"], drive_lead_s(model.drive, w), w, self._cycle_s) if play else None
        )
        self._use(self._law(settings.added_damping_ratio))

    def _law(self, added_damping_ratio: float) -> _Law:
        """Raises UserError for a return time that the composite law cannot keep."""
        model, settings = self._model, self._settings
        mode = model.arm.modes[0]
        w = mode.angular_frequency
        gain = 2.0 * added_damping_ratio * w / (mode.participation * self._length)
        lag_s = most_damping_lag_s(mode.damping_ratio + added_damping_ratio, w)
        composite = None
        if settings.law == "composite":
            composite = CompositeControl(model, self._length, gain, settings.return_time_s)
        return _Law(gain, drive_lead_s(model.drive, w) - lag_s, composite)

    def _use(self, law: _Law) -> None:
        self._gain = law.gain
        self.lead_s = law.lead_s
        """How far ahead of the present is the deflection that the joint follows."""
        self._composite = law.composite
        self._next_law = None

    def adjust(self, added_damping_ratio: float) -> None:
        """Damp by another ratio: fade out, go over at zero, and fade in, so that the command makes no step."""
        self._next_law = self._law(added_damping_ratio)

    def _goes_over(self) -> bool:
        """Whether the damping is on its way to another ratio, and therefore fades out in this cycle."""
        if self._next_law is None:
            return False
        if self._weight == 0.0:
            self._use(self._next_law)
        return True

    def see_sample(self, time_s: float) -> None:
        """A visual sample with a measurement was read."""
        self._last_measured_s = time_s

    @property
    def full(self) -> bool:
        """Whether the damping is fully faded in."""
        return self._weight == 1.0

    def cut(self) -> None:
        """Go to zero at once, and fade in again."""
        self._weight = 0.0

    def begin_anew(self) -> None:
        """The image zero has changed: go to zero at once, and fade in when the new zero is known."""
        self.cut()
        if self._composite is not None:
            self._composite.restart()

    def anchor(self, joint_position_rad: float) -> None:
        """Take the joint's present position as the position to which the reference has led it."""
        self._anchored = True
        self._commanded.rest_at(joint_position_rad)
        if self._composite is not None:
            self._composite.restart()

    def follow_reference(self, reference_rad_s: float, joint_position_rad: float, cycles: int) -> None:
        """Update the position that the external reference alone would give the joint."""
        if not self._anchored:
            self.anchor(joint_position_rad)
            return
        if cycles == 1:
            self._commanded.advance(reference_rad_s)
            return
        for _ in range(min(cycles, STEPWISE_CYCLES)):
            self._commanded.advance(reference_rad_s)
        if cycles > STEPWISE_CYCLES:
            self._commanded.advance_many(cycles - STEPWISE_CYCLES, reference_rad_s)

    def see_cycle(
        self, cycle: int, estimate: Estimate, samples: list[VisualSample], joint: JointMotion
    ) -> None:
        """Pass a cycle to the composite law, after follow_reference."""
        if self._composite is not None:
            self._composite.see_cycle(cycle, self._commanded.position_rad, estimate, samples, joint)

    def predicted_m(self, estimate: Estimate) -> float:
        """The deflection that the joint follows: the present one, advanced by `lead_s`."""
        rate = estimate.deflection_rate_m_s
        bend = -self._w * self._w * estimate.vibration_m - self._decay * rate
        lead = self.lead_s
        return estimate.deflection_m + lead * rate + 0.5 * lead * lead * bend

    def _sure(self, estimate: Estimate) -> bool:
        """Whether damping may fade in on a prediction. A prediction without a deviation is accepted."""
        std = estimate.deflection_std_m
        if not std * abs(self._gain) > self._sure_rad_s:
            return True
        q, of_rate = estimate.vibration_m, estimate.deflection_rate_m_s / self._w
        of_delay = self._w * estimate.delay.std_s
        share = _SURE_OF_AMPLITUDE * _SURE_OF_AMPLITUDE + 0.5 * of_delay * of_delay
        return not std * std > share * (q * q + of_rate * of_rate)

    def _across(
        self,
        crossing: PlayCrossing,
        play: GearPlay,
        estimate: Estimate,
        vibration_m: float,
        wanted_rad_s: float,
    ) -> float:
        """The motor's velocity across the play, within the damping's limit."""
        lead, w = self.lead_s, self._w
        rate = estimate.deflection_rate_m_s - w * w * lead * estimate.vibration_m
        across = crossing.velocity_rad_s(self._gain * vibration_m, self._gain * rate, play)
        most = self._settings.max_velocity_rad_s
        return (
            min(max(across, -most - wanted_rad_s), most - wanted_rad_s) if abs(wanted_rad_s) < most else 0.0
        )

    def velocity_rad_s(
        self,
        estimate: Estimate,
        time_s: float,
        allowed: bool,
        joint_position_rad: float,
        joint_age_s: float,
        play: GearPlay | None = None,
    ) -> tuple[float, DampingStatus]:
        """The damping part of the joint velocity, and its status.

        joint_age_s: age of the drive's report; NaN for a drive that reports nothing. play: between motor and joint.
        """
        self.at_limit = False
        allowed = not self._goes_over() and allowed
        settings = self._settings
        age = time_s - self._last_measured_s
        fresh = (settings.stale_after_s - age) / settings.fade_s
        fresh = fresh if fresh < 1.0 else 1.0
        predicted = self.predicted_m(estimate)
        # following a static deflection would make the joint creep and damp nothing
        vibration = predicted - estimate.static_m
        grounds = True
        if not isfinite(predicted) or estimate.status is _INVALID or estimate.status is _UNESTIMATED:
            status, grounds = DampingStatus.NO_PREDICTION, False
        elif fresh <= 0.0:
            status, grounds = DampingStatus.VISION_STALE, False
        elif joint_age_s > DRIVE_SILENT_S:
            status, grounds = DampingStatus.DRIVE_SILENT, False
        elif allowed and self._weight < 1.0 and not self._sure(estimate):
            status, grounds = DampingStatus.NO_PREDICTION, False
        elif not allowed:
            status = DampingStatus.OFF
        else:
            status = _ACTIVE
        if not grounds:
            self._weight = 0.0
            return 0.0, status
        change = self._cycle_s / (_ENTRY_S if allowed else settings.fade_s)
        self._weight = min(1.0, self._weight + change) if allowed else max(0.0, self._weight - change)
        if self._weight == 0.0:
            return 0.0, status
        away = self._commanded.position_rad - joint_position_rad
        if self._composite is not None:
            both = self._composite.velocity_rad_s(estimate, away)
        else:
            both = self._gain * vibration + away / settings.return_time_s
        if self._crossing is not None and play is not None:
            both += self._across(self._crossing, play, estimate, vibration, both)
        if not isfinite(both):
            self._weight = 0.0
            return 0.0, DampingStatus.NO_PREDICTION
        wanted, most = both * self._weight * fresh, settings.max_velocity_rad_s
        self.at_limit = not -most <= wanted <= most
        return (min(max(wanted, -most), most) if self.at_limit else wanted), status


_INVALID, _UNESTIMATED = Status.INVALID, Status.UNESTIMATED
_ACTIVE = DampingStatus.ACTIVE  # looked up once: to read an enumeration's member costs as much as a call
