"""What may be wrong with a driven joint: each cause in its forms, as numbers of the grey box that are set free.

A form lists the numbers and the values from which a fit begins. Structure (a lag of the amplifier, a further mode, a
stiffness of the joint) competes with the causes for what the linear start leaves, and is no finding: nobody has said
that the rig is without it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.bounds import LONGEST_DELAY_S
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.fitting.freedom import (
    STATED,
    before_amplifier,
    shows,
    shows_angle,
    shows_bending,
    shows_joint,
    shows_link,
)
from stillarm.diagnosis.driven.greybox.input_path import STEADY
from stillarm.diagnosis.driven.greybox.laws import pull_of
from stillarm.diagnosis.driven.mechanisms.anew import anew_with
from stillarm.diagnosis.driven.mechanisms.gaps import gaps
from stillarm.diagnosis.driven.mechanisms.missing import missing_force
from stillarm.diagnosis.driven.mechanisms.rubbing import anew_with_friction
from stillarm.diagnosis.driven.mechanisms.shifts import best_shift
from stillarm.diagnosis.driven.mechanisms.unknown_gear import (
    gear_is_unknown,
    gravity_behind_a_gear,
    has_geared_gravity,
)
from stillarm.diagnosis.driven.mechanisms.waves import strongest_waves
from stillarm.diagnosis.driven.recording.own import base_of
from stillarm.diagnosis.driven.recording.regression import regressed_joint

Array = NDArray[np.float64]
Starts = Iterator[dict[str, float]]
STRUCTURE = ""
AMPLIFIER_LAG = "a lag of the amplifier"
STIFF_JOINT = "a stiffness of the joint"
_NO_NUMBER = ("late", STEADY)  # a mark; an initial state, as each block has
_FAR = 2  # samples: to which the usual starts lead
_SLIGHT = 0.1  # samples: a jump behind a longer lag is another shape, which no first order leads to
_HUNDREDTH = 0.01  # of the usual force: as good as none, and clear of rounding


@dataclass(frozen=True)
class Form:
    """cause: identifier, STRUCTURE for none. numbers: set free. starts: from which values, of the fit so far.

    fits: whether the recording can show it. hidden: whether no first order tells, as the fit's own numbers make it up;
    its starts are taken as they are.
    """

    cause: str
    words: str
    numbers: tuple[str, ...]
    starts: Callable[[DrivenFit], Starts]
    fits: Callable[[DrivenFit], bool] = field(default=lambda fitted: True)
    play: bool = False
    hidden: bool = False

    @property
    def price(self) -> int:
        """How many numbers it adds."""
        return len([one for one in self.numbers if base_of(one) not in _NO_NUMBER])


def force_of(fitted: DrivenFit) -> float:
    """How strongly the joint is usually driven, rad/s^2."""
    return float(abs(fitted.numbers["gain"]) * np.std(fitted.run.drive))


def _speed(fitted: DrivenFit) -> float:
    return float(np.std(fitted.run.states[:, 1])) + 1e-12


def _coulomb(fitted: DrivenFit) -> Starts:
    for start in _coulomb_by_direction(fitted):
        yield {name: value for name, value in start.items() if name != "coulomb_difference"}


def _coulomb_by_direction(fitted: DrivenFit) -> Starts:
    numbers, arm = fitted.numbers, np.zeros(fitted.box.driven.samples)
    for i in range(1, fitted.box.modes + 1):
        w, zeta = np.exp(numbers[f"log_w_{i}"]), numbers[f"zeta_{i}"]
        q, v = fitted.run.states[:, 2 * i], fitted.run.states[:, 2 * i + 1]
        arm += pull_of(numbers, i) * (w * w * q + 2.0 * zeta * w * v)
    found = regressed_joint(fitted.box.driven, arm, numbers)
    if found is not None and found[2] > 0.0:
        yield {"gain": found[0], "damping": found[1], "coulomb": found[2], "coulomb_difference": found[3]}
        yield {
            "damping": 0.8 * numbers["damping"], "delay": 0.0,
            "coulomb": 1.5 * found[2], "coulomb_difference": 1.5 * found[3],
        }  # fmt: skip
    for share in (0.1, 0.4):
        mean, slower = share * force_of(fitted), 0.7 * numbers["damping"]
        yield {"coulomb": mean, "coulomb_difference": 0.0, "damping": slower}


def _stribeck(fitted: DrivenFit) -> Starts:
    begun = fitted.numbers.get("coulomb", 0.0) or 0.15 * force_of(fitted)
    for speed in (0.05, 0.3):
        yield {
            "coulomb": begun,
            "stribeck": 0.5 * begun,
            "log_stribeck_velocity": float(np.log(speed * _speed(fitted))),
        }


def _square(fitted: DrivenFit) -> Starts:
    yield {
        "viscous_square": 0.1 * force_of(fitted) / _speed(fitted) ** 2,
        "damping": 0.7 * fitted.numbers["damping"],
    }


def _asymmetry(fitted: DrivenFit) -> Starts:
    yield {"viscous_asymmetry": 1e-3 * force_of(fitted) / _speed(fitted)}


def _ripple(fitted: DrivenFit) -> Starts:
    for one in strongest_waves(fitted):
        yield {"ripple_cycles": one.cycles, "ripple_sine": one.sine, "ripple_cosine": one.cosine}


def _small(*names: str) -> Callable[[DrivenFit], Starts]:
    """A hundredth of what usually drives the joint, each by itself: laws of which either sign may be."""

    def starts(fitted: DrivenFit) -> Starts:
        for name in names:
            yield {**dict.fromkeys(names, 0.0), name: _HUNDREDTH * force_of(fitted) * _per(name, fitted)}

    return starts


def _per(name: str, fitted: DrivenFit) -> float:
    """What a law's number is multiplied by, in SI, so that it makes a hundredth of the usual force."""
    travel = float(np.std(fitted.run.states[:, 0])) + 1e-12
    bent = float(np.std(fitted.run.states[:, 2])) + 1e-12 if fitted.box.modes else 1.0
    return {"stiffness": 1.0 / travel, "arm_cubic": 1.0 / bent**3}.get(name, 1.0)


def _dead_zone(fitted: DrivenFit) -> Starts:
    for share in (0.05, 0.2, 0.5):
        yield {"dead_zone": share * float(np.std(fitted.box.driven.u))}


def _dead_cut(fitted: DrivenFit) -> Starts:
    for share in (0.02, 0.1, 0.4):
        yield {"dead_cut": share * float(np.std(fitted.box.driven.u))}


def _limit(fitted: DrivenFit) -> Starts:
    size = np.abs(fitted.box.driven.u)
    for share in (0.95, 0.8, 0.6):
        yield {"limit": share * float(np.quantile(size, 0.998))}


def _late(fitted: DrivenFit) -> Starts:
    for samples in (3.0, 10.0):
        yield {"delay": samples * fitted.box.driven.step_s, "late": 1.0}


def _lag(fitted: DrivenFit) -> Starts:
    """In place of the delay, which is the same to first order."""
    step_s = fitted.box.driven.step_s
    for more in (0.5, 5.0):
        yield {"lag": max(fitted.numbers["delay"], 0.0) + more * step_s, "delay": 0.0, STEADY: 1.0}


def _damped(fitted: DrivenFit) -> Starts:
    """A joint that no sensor looks at: a bending shows its damping as a pole of its own. An accelerometer may too, but
    on the measured robot arm (docs/measured-rigs.md) it is then a mode that damping makes up for."""
    for damping in (1.0, 8.0):
        yield {"damping": damping}


def _onset(fitted: DrivenFit) -> Starts:
    for part in (0.2, 0.35, 0.5, 0.65, 0.8):
        for step in (0.3, -0.25):
            yield {"inertia_step": step, "onset": part * fitted.box.driven.duration_s}


FORMS = (
    Form("joint_coulomb_friction", "the same both ways", ("coulomb",), _coulomb, shows_joint),
    Form("joint_coulomb_friction", "the same both ways", ("coulomb",), anew_with_friction, shows_joint, hidden=True),
    Form("joint_coulomb_friction", "by direction", ("coulomb", "coulomb_difference"), _coulomb_by_direction,
         shows_joint),
    Form("joint_stribeck_friction", "larger at rest", ("coulomb", "stribeck", "log_stribeck_velocity"), _stribeck,
         shows_joint),
    Form("joint_viscous_friction", "with the square of velocity", ("viscous_square",), _square, shows_joint),
    Form("joint_viscous_friction", "by direction", ("viscous_asymmetry",), _asymmetry, shows_joint),
    Form("torque_ripple", "over the joint's angle", ("ripple_cycles", "ripple_sine", "ripple_cosine"), _ripple,
         lambda fitted: shows_joint(fitted) and not has_geared_gravity(fitted)),
    Form("torque_offset", "constant", ("offset",), _small("offset"), shows_joint),
    Form("torque_offset", "constant", ("offset",), anew_with("offset"), shows_joint, hidden=True),
    Form("gravity_load", "over the joint's angle", ("gravity_sine", "gravity_cosine"),
         _small("gravity_sine", "gravity_cosine"), shows_angle),
    Form("gravity_load", "over the joint's angle", ("gravity_sine", "gravity_cosine"),
         anew_with("gravity_sine", "gravity_cosine"), shows_angle, hidden=True),
    Form("gravity_load", "over an angle behind an unknown gear", ("gravity_cycles", "gravity_sine", "gravity_cosine"),
         gravity_behind_a_gear, gear_is_unknown),
    Form("amplifier_dead_zone", "about zero", ("dead_zone",), _dead_zone, before_amplifier),
    Form("amplifier_dead_zone", "small inputs are cut", ("dead_cut",), _dead_cut, before_amplifier),
    Form("drive_saturation", "of the input", ("limit",), _limit, before_amplifier),
    Form("inertia_change", "from an onset on", ("inertia_step", "onset"), _onset, shows_joint),
    Form("gear_backlash", "between motor and joint", ("gap", "share"), gaps, shows_link, play=True),
    Form("channel_delay", "of all sensors against the input", ("delay", "late"), _late),
    Form("coulomb_damping", "of the arm", ("arm_coulomb",),
         lambda fitted: iter([{"arm_coulomb": 0.05 * _arm_force(fitted)}]), shows_bending),
    Form("cubic_stiffness", "of the arm", ("arm_cubic",), _small("arm_cubic"), shows_bending),
    Form(STRUCTURE, AMPLIFIER_LAG, ("lag", STEADY), _lag, before_amplifier, hidden=True),
    Form(STRUCTURE, "a damping of the joint", ("damping",), _damped,
         lambda fitted: shows("deflection")(fitted) and not shows_joint(fitted) and STATED not in fitted.numbers),
    Form(STRUCTURE, STIFF_JOINT, ("stiffness",), _small("stiffness"), shows("position", "motor")),
)  # fmt: skip


def _arm_force(fitted: DrivenFit) -> float:
    return float(np.exp(2.0 * fitted.numbers["log_w_1"]) * np.std(fitted.run.states[:, 2]))


def forms_for(fitted: DrivenFit) -> list[Form]:
    """All forms that the recording may show beside what the fit has already."""
    found = [one for one in FORMS if one.fits(fitted) and not set(one.numbers) <= set(fitted.free)]
    outputs = fitted.box.driven.outputs
    positions = [one for one in outputs if one.kind in ("position", "motor")]
    for one in outputs if len(outputs) > 1 else ():
        if f"delay {one.name}" not in fitted.free:
            found.append(Form("channel_delay", f"of {one.name}", (f"delay {one.name}",), _delays(one.name)))
        if f"lag {one.name}" not in fitted.free:
            found.append(
                Form("sensor_lag", f"a filter's lag in {one.name}", (f"lag {one.name}",), _lags(one.name))
            )
        scaled = one.kind in ("velocity", "motor") and positions and one is not positions[0] and one.stated
        known = STATED in fitted.numbers
        if scaled and not known and f"scale {one.name}" not in fitted.free:
            found.append(Form("sensor_scale", f"of {one.name}", (f"scale {one.name}",), _scale(one.name)))
    if STATED in fitted.numbers:
        found += _against_the_model(fitted)
    return found


def _against_the_model(fitted: DrivenFit) -> list[Form]:
    """What may be otherwise than the model file states."""
    forms = [
        Form("joint_viscous_friction", "against the model", ("damping",), _more("damping")),
        Form("inertia_change", "against the model", ("inertia_excess",), _fixed("inertia_excess", 0.1)),
    ]
    if fitted.box.modes:
        carried = tuple(f"carries_{i}" for i in range(1, fitted.box.modes + 1))
        forms.append(Form("inertia_change", "a payload at the tip", carried, _more(*carried)))
    for one in fitted.box.driven.outputs:
        seen_in_its_size = one.stated and f"direct {one.name}" not in fitted.free
        if seen_in_its_size and f"scale {one.name}" not in fitted.free:
            forms.append(Form("sensor_scale", f"of {one.name}", (f"scale {one.name}",), _scale(one.name)))
    return [one for one in forms if not set(one.numbers) <= set(fitted.free)]


def _fixed(name: str, value: float) -> Callable[[DrivenFit], Starts]:
    def starts(fitted: DrivenFit) -> Starts:
        yield {name: value}

    return starts


def _more(*names: str) -> Callable[[DrivenFit], Starts]:
    def starts(fitted: DrivenFit) -> Starts:
        yield {name: 1.2 * fitted.numbers[name] + 1e-3 for name in names}

    return starts


def _delays(name: str) -> Callable[[DrivenFit], Starts]:
    """Begins, too, where the simulation looks most like the sensor: past half a period of what vibrates, no fit leads
    from a short delay to a long one."""

    def starts(fitted: DrivenFit) -> Starts:
        driven = fitted.box.driven
        measured = next(one.values for one in driven.outputs if one.name == name)
        longest = round(LONGEST_DELAY_S / driven.step_s)
        shift = best_shift(measured, fitted.run.outputs[name], longest)
        far = (float(shift),) if abs(shift) > _FAR else ()
        for samples in (_SLIGHT, 2.0, -2.0, *far):
            yield {f"delay {name}": samples * driven.step_s}

    return starts


def _lags(name: str) -> Callable[[DrivenFit], Starts]:
    def starts(fitted: DrivenFit) -> Starts:
        for samples in (_SLIGHT, 2.0, 10.0):
            yield {f"lag {name}": samples * fitted.box.driven.step_s}

    return starts


def _scale(name: str) -> Callable[[DrivenFit], Starts]:
    def starts(fitted: DrivenFit) -> Starts:
        yield {f"scale {name}": 1.05 * fitted.numbers.get(f"scale {name}", 1.0)}

    return starts


def box_of(form: Form, fitted: DrivenFit) -> DrivenFit:
    """The fit from which a form's fits begin: with a motor of its own where there is play."""
    if not form.play or fitted.box.play:
        return fitted
    states = np.concatenate([fitted.states, fitted.states[:, :2]], axis=1)
    return replace(fitted, box=replace(fitted.box, play=True), states=states)


__all__ = ["FORMS", "STRUCTURE", "Form", "box_of", "force_of", "forms_for", "missing_force"]
