"""What a declaration of a cause says, and where its law may act.

A law is a plain Python function; the arm's stepper compiles those that act in it, so that reading declarations loads no
compiler. A law takes what its site gives, then the cause's own numbers in the order of its parameters (onset_s among
them, texts and truths not). t: s from the recording's start, never negative.

| acts        | the site gives               | the law returns                                                      |
|-------------|------------------------------|----------------------------------------------------------------------|
| force       | t, theta, omega, q, v, w     | acceleration of the first mode, m/s^2                                |
| friction    | t, theta, omega, q, v, w     | the largest dry friction on the first mode, m/s^2, never negative    |
| frequency   | t, mode, first_hz            | frequency of mode number `mode` (0 = first) over the declared one    |
| command     | command                      | the velocity command that the drive obeys, rad/s                     |
| play        |                              | width of the play between motor and joint, rad                       |
| sensitivity | t                            | factor on the accelerometer's scale                                  |
| reading     | t, tip_angle                 | acceleration added to the reading, m/s^2                             |
| impulse     | sign                         | acceleration added to one sample, m/s^2, at rate_hz, by chance       |
| image       | d, t                         | displacement added to the image's d, px; numbers or arrays           |
| period      |                              | frame period over the declared one                                   |
| delay       | t                            | capture delay added, s                                               |
| burst       | since                        | delay added, s, `since` s after a burst began; they do at rate_hz    |
| loss        | drawn                        | whether a frame is lost; drawn: uniform in 0..1                      |
| age         | t                            | how many exposures old the image is                                  |
| clock       | t                            | what a clock has jumped by, s                                        |
| key         |                              | no law: the parameters replace keys of the model file (`key`)        |

theta, omega: joint angle, rad, and rate, rad/s, behind any play. q, v, w: deflection of the first mode, m, its rate,
m/s, and its present angular frequency, rad/s. Arm laws compare real parts only and use no abs(), so that a complex
argument carries a derivative through them (complex step); those of reading and image take arrays as well as numbers.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import nan, pi
from typing import Any, Literal

Place = Literal["arm", "drive", "accelerometer", "camera", "timing"]
Value = float | int | bool | str
Acts = Literal[
    "force", "friction", "frequency", "command", "play", "sensitivity", "reading", "impulse",
    "image", "period", "delay", "burst", "loss", "age", "clock", "key",
]  # fmt: skip

SEPARATES = {
    "arm": "let the arm ring down freely with damping off, from a large and from a small deflection",
    "drive": "move the joint at several speeds with quick and slow reversals, and record joint_position_rad and "
    "joint_velocity_rad_s",
    "accelerometer": "record a rest of ten seconds, a ring-down and a move in one recording, with the camera",
    "camera": "move the joint rigidly and slowly through its whole range and back to the same pose twice",
    "timing": "record with the camera's stamps, and move the joint throughout",
}
"""By place: what to record to tell a cause from those that its file does not name."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a cause; its unit is its name's suffix.

    lowest, highest: what a model file may say, both included
    typical: sizes worth looking for on an ordinary rig, taken from `neutral` on, to both sides where signed
    neutral: the value at which nothing happens; NaN where no value is so (of a replacement it is the declared one)
    default: of an optional parameter; None: required
    choices: of a text; kind: how the value is written
    tried: values from which a search begins, where the usual range does not say enough
    """

    name: str
    unit: str
    lowest: float = 0.0
    highest: float = 0.0
    typical: tuple[float, float] = (0.0, 0.0)
    signed: bool = False
    neutral: float = nan
    default: Value | None = None
    kind: Literal["number", "whole", "truth", "text"] = "number"
    choices: tuple[str, ...] = ()
    tried: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Cause:
    """A physical cause by which a rig departs from its model: all that the program says of it.

    name: a noun phrase, as the report has it. sees, note: what one sees, in one sentence, and what else is to be known.
    provoke: what to do so that it shows. confused_with: by other cause, the experiment that separates the two (said in
    one of the two files). acts: where the law enters, see above. key: dotted key of the model file that it replaces, or
    the list that it adds to. repeatable: whether a model may hold several effects of it. corner: whether a
    law of force has a corner where the first mode turns, v = 0 (friction always has). foreign: whether a law of force
    follows from time and joint alone, whatever the first mode does. limit: what has gone wrong,
    where the cause has taken the arm beyond what the equation holds for; takes t, first_hz, q and the law's numbers.
    """

    identifier: str
    place: Place
    name: str
    sees: str
    equation: str
    parameters: tuple[Parameter, ...]
    provoke: str
    acts: Acts
    law: Callable[..., Any] | None = None
    key: str = ""
    note: str = ""
    confused_with: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = False
    corner: bool = False
    foreign: bool = False
    limit: Callable[..., str | None] | None = None

    @property
    def numbers(self) -> tuple[Parameter, ...]:
        """The parameters that the law takes, in its order."""
        return tuple(one for one in self.parameters if one.kind in ("number", "whole"))

    def arguments(self, values: Mapping[str, Any]) -> tuple[float, ...]:
        """The law's own arguments from an effect's values by name."""
        return tuple(float(values[one.name]) for one in self.numbers)

    def is_idle(self, values: Mapping[str, Any]) -> bool:
        """Whether an effect of these values changes nothing."""
        return any(values[one.name] == one.neutral for one in self.numbers)


def size(
    name: str,
    unit: str,
    highest: float,
    low: float,
    high: float,
    *,
    signed: bool = False,
) -> Parameter:
    """How large a cause is: nothing at zero, usually `low` to `high`, at most `highest`; signed: to either side."""
    return Parameter(name, unit, -highest if signed else 0.0, highest, (low, high), signed, 0.0)


def replacing(name: str, unit: str, lowest: float, highest: float, low: float, high: float) -> Parameter:
    """The value that takes the declared one's place."""
    return Parameter(name, unit, lowest, highest, (low, high))


def frequency(low: float, high: float) -> Parameter:
    """Frequency of a foreign force or voltage."""
    return Parameter("frequency_hz", "Hz", 0.01, 1000.0, (low, high))


ONSET = Parameter("onset_s", "s", 0.0, 1e7)
OTHERS = Parameter("higher_modes_share", "1", -10.0, 10.0, (0.0, 1.0), default=1.0)
"""How much of the first mode's relative change of frequency the others share."""
PHASE = Parameter("phase_rad", "rad", -1e3, 1e3, (0.0, 2.0 * pi), default=0.0, tried=(0.0, 0.5 * pi))
