"""What a column's name says: quantity, part, command or measurement, unit. A name that says nothing gives "unknown"."""

import re
from dataclasses import dataclass, replace
from itertools import pairwise

from stillarm.tables.roles import BY_NAME, IGNORE, UNKNOWN
from stillarm.tables.units import size_of

TIME, COUNTER, FLAG, CONSTANT = "time", "count", "flag", "constant"
ANGLE, VELOCITY, ANGULAR_ACCELERATION = "angle", "angular velocity", "angular acceleration"
ACCELERATION, DEFLECTION, DISPLACEMENT = "acceleration", "deflection", "image displacement"
TORQUE, FORCE, CURRENT, VOLTAGE, STRAIN = "torque", "force", "current", "voltage", "strain"
TEMPERATURE, ROTATION, SPREAD, AGE = "temperature", "image rotation", "variance", "age"
EXPOSURE = "exposure"

_WORDS: dict[str, str] = {
    TIME: "t time timestamp timestamps stamp sec secs second seconds received started captured clock zeit epoch tstamp "
    "mid_exposure logtime",
    COUNTER: "frame frames index idx count counter seq sequence cycle tick ticks row nr number features inliers",
    FLAG: "allowed enable enabled status state flag mode operator restarted valid trigger limit",
    ANGLE: "theta th q pos position angle encoder enc phi alpha winkel psi gamma joint angular_position heading",
    VELOCITY: "vel velocity speed qd dq dtheta thetad thetadot qdot thd dth omega gyro angular_velocity rpm drehzahl",
    ANGULAR_ACCELERATION: "qdd ddq ddtheta thetadd thetaddot qddot angular_acceleration",
    ACCELERATION: "acc accel acceleration accelerometer ax ay az accx accy accz accelx accely accelz beschleunigung "
    "linear_acceleration acc_x acc_y acc_z imu",
    DEFLECTION: "deflection defl bend bending flex tipdeflection durchbiegung",
    DISPLACEMENT: "displacement disp dx dy shift",
    TORQUE: "torque tau trq effort moment drehmoment tq",
    FORCE: "force load kraft",
    CURRENT: "current curr cur i im iq id amp amps amperage strom i_a",
    VOLTAGE: "voltage volt volts u_a spannung vm vmot vin",
    STRAIN: "strain gauge sg eps epsilon straingauge strain_gauge dms",
    TEMPERATURE: "temperature temp tmp",
    ROTATION: "rotation rot",
    SPREAD: "variance covariance std sigma",
    AGE: "age",
    EXPOSURE: "exposure shutter",
}
_QUANTITY = {word: quantity for quantity, words in _WORDS.items() for word in words.split()}
_COMMAND = frozenset(
    [
        "cmd",
        "command",
        "commanded",
        "ref",
        "reference",
        "setpoint",
        "sp",
        "desired",
        "des",
        "target",
        "soll",
        "set",
        "goal",
        "rf",
    ]
)
_MEASURED = frozenset(["meas", "measured", "act", "actual", "ist", "fb", "feedback", "sensor", "obs"])
_MODELLED = frozenset(
    [
        "sim",
        "simulated",
        "model",
        "modelled",
        "est",
        "estimated",
        "hat",
        "pred",
        "predicted",
        "obsv",
        "observer",
    ]
)
_PLACE = {"motor": "motor", "mot": "motor", "m": "motor", "mtr": "motor", "rotor": "motor"} | {
    "tip": "tip",
    "end": "tip",
    "link": "link",
    "arm": "link",
    "joint": "joint",
    "jnt": "joint",
    "hub": "joint",
    "load": "joint",
}
_RANK = (
    SPREAD,
    STRAIN,
    AGE,
    EXPOSURE,
    DEFLECTION,
    TIME,
    FLAG,
    ANGULAR_ACCELERATION,
    ACCELERATION,
    VELOCITY,
    TORQUE,
    CURRENT,
    VOLTAGE,
    FORCE,
    TEMPERATURE,
    DISPLACEMENT,
    ROTATION,
    COUNTER,
    ANGLE,
)  # of several words the first counts
_DIMENSIONS = {
    TIME: ("s",),
    ANGLE: ("rad",),
    VELOCITY: ("rad_s",),
    ANGULAR_ACCELERATION: ("rad_s2",),
    ACCELERATION: ("m_s2",),
    DEFLECTION: ("m", "rad"),
    DISPLACEMENT: ("px",),
    TORQUE: ("n_m",),
    FORCE: ("n",),
    CURRENT: ("a",),
    VOLTAGE: ("v",),
    STRAIN: ("strain",),
    ROTATION: ("rad",),
    AGE: ("s",),
    EXPOSURE: ("s",),
}
_OF_DIMENSION = {
    "rad_s": VELOCITY,
    "rad_s2": ANGULAR_ACCELERATION,
    "m_s2": ACCELERATION,
    "n_m": TORQUE,
    "a": CURRENT,
    "v": VOLTAGE,
    "strain": STRAIN,
    "px": DISPLACEMENT,
    "n": FORCE,
    "rad": ANGLE,
}


@dataclass(frozen=True)
class Sense:
    """quantity: one of the constants above, or "unknown". part: joint, motor, tip, link or "". kind: command, measured,
    modelled or "". unit: as it is written, or "". role: where the name is a role's own.
    """

    quantity: str = UNKNOWN
    part: str = ""
    kind: str = ""
    unit: str = ""
    role: str = ""


def sense_of(name: str, stated_unit: str = "") -> Sense:
    """What a name says, with the unit that the file states beside it."""
    plain = re.sub(r"(\(:,\d+\)|\[:,\d+\]|\[\d+\])$", "", name.strip())
    plain, unit = _unit_in_brackets(plain)
    if plain in BY_NAME and plain not in (UNKNOWN, IGNORE):
        return _of_role(plain)
    unit = unit or stated_unit
    words = _words(plain.rpartition("/")[2])
    if not unit:
        words, unit = _unit_suffix(words)
    sense = _of_words(words)
    if unit:
        sense = replace(sense, unit=unit)
        sense = _with_unit(sense)
    if sense.quantity == UNKNOWN and "." in plain:
        return _of_path(plain, sense)
    return sense


def matrix_of(name: str) -> str:
    """The matrix that a column is of, or a name of its own."""
    return (
        name.split("(:", maxsplit=1)[0]
        if "(:" in name
        else name.split("[:", maxsplit=1)[0]
        if "[:" in name
        else name
    )


def without_kind(name: str) -> str:
    """A name without the words for command, measurement and model: alike for X_ref(:,1) and X_meas(:,1)."""
    kinds = _COMMAND | _MEASURED | _MODELLED
    return " ".join(
        word
        for word in re.split(r"[^A-Za-z0-9:,()\[\]]+|(?=[(\[])", name.lower())
        if word and word not in kinds
    )


def _of_path(plain: str, sense: Sense) -> Sense:
    """A path such as position.shoulder or imu.linear_acceleration.x: its last part that says something."""
    for part in reversed(plain.split(".")[:-1]):
        found = _of_words(_words(part))
        if found.quantity != UNKNOWN:
            return replace(found, unit=sense.unit or found.unit, kind=sense.kind or found.kind)
    return sense


def _of_role(name: str) -> Sense:
    sense = _of_words(_unit_suffix(_words(name))[0])
    unit = {"rad_s": "rad/s", "m_s2": "m/s2", "n_m": "Nm"}.get(
        BY_NAME[name].dimension, BY_NAME[name].dimension
    )
    if name in ("input", "output"):
        return Sense(name, role=name)
    return replace(sense, unit=unit, role=name)


def _unit_in_brackets(name: str) -> tuple[str, str]:
    match = re.search(r"[\[({]\s*([^\[\](){}]*)\s*[\])}]\s*$", name)
    if match and (size_of(match[1]) is not None or match[1].strip() in ("-", "%", "°C", "C", "1")):
        return name[: match.start()].strip(), match[1].strip()
    return name, ""


def _words(text: str) -> list[str]:
    """Words of a name, split at marks and where small letters meet capitals; digits at their ends fall off."""
    text = re.sub(r"([a-z])([A-Z][a-z])", r"\1_\2", text)
    parts = [part for part in re.split(r"[^A-Za-z0-9µ°]+", text) if part]
    found = []
    for part in parts:
        word = part.lower()
        found.append(word if word in _QUANTITY else word.rstrip("0123456789") or word)
    return found


def _unit_suffix(words: list[str]) -> tuple[list[str], str]:
    """Words without the unit that they end in: joint velocity rad s -> rad/s. theta_m is a motor's angle, no length."""
    for count in (2, 1):
        if len(words) <= count:
            continue
        tail = words[-count:]
        text = (
            "/".join(tail) if count == 2 and tail[0] in ("rad", "deg", "m", "mm", "rev") else "_".join(tail)
        )
        size = size_of(text)
        before = _of_words(words[:-count]).quantity
        fits = before not in _DIMENSIONS or (size is not None and size[0] in _DIMENSIONS[before])
        if size is not None and (fits or len(text) > 1):
            return words[:-count], text
    return words, ""


def _of_words(words: list[str]) -> Sense:
    joined = next((_QUANTITY[f"{a}_{b}"] for a, b in pairwise(words) if f"{a}_{b}" in _QUANTITY), None)
    quantities = [_QUANTITY[word] for word in words if word in _QUANTITY]
    quantity = joined or next((q for q in _RANK if q in quantities), UNKNOWN)
    if quantity == ANGLE and any(word in ("dot", "d") for word in words):
        quantity = VELOCITY
    if quantity in (ANGLE, VELOCITY) and any(word in ("ddot", "dd") for word in words):
        quantity = ANGULAR_ACCELERATION
    part = next((_PLACE[word] for word in words if word in _PLACE), "")
    if words and re.fullmatch("im", words[0]):
        part = "motor"
    kind = "command" if _COMMAND & set(words) else "measured" if _MEASURED & set(words) else ""
    if _MODELLED & set(words) and not kind:
        kind = "modelled"
    return Sense(quantity, part, kind)


def _with_unit(sense: Sense) -> Sense:
    """A unit that contradicts the word wins: `speed [rad]` is an angle, `position_m` no angle."""
    size = size_of(sense.unit)
    if size is None:
        return sense
    dimension = size[0]
    if sense.quantity in _DIMENSIONS and dimension in _DIMENSIONS[sense.quantity]:
        return sense
    if sense.quantity in (COUNTER, FLAG, SPREAD):
        return sense
    if sense.quantity == UNKNOWN and dimension in ("s", "m"):
        return replace(sense, quantity=TIME if dimension == "s" else UNKNOWN)
    return replace(sense, quantity=_OF_DIMENSION.get(dimension, UNKNOWN))
