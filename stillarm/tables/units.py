"""Units as people write them, and their size in SI.

`dimension` is the SI unit of a role's name: "rad", "rad_s", "m_s2". SI: the BIPM's brochure, 9th edition; standard
gravity 9.80665 m/s^2 (3rd CGPM).
"""

from math import pi

_DEGREE = pi / 180.0
_TURN = 2.0 * pi
_GRAVITY = 9.80665

UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "sec": ("s", 1.0),
    "second": ("s", 1.0),
    "seconds": ("s", 1.0),
    "min": ("s", 60.0),
    "ms": ("s", 1e-3),
    "msec": ("s", 1e-3),
    "us": ("s", 1e-6),
    "µs": ("s", 1e-6),
    "usec": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "nsec": ("s", 1e-9),
    "rad": ("rad", 1.0),
    "radian": ("rad", 1.0),
    "radians": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", _DEGREE),
    "degree": ("rad", _DEGREE),
    "degrees": ("rad", _DEGREE),
    "°": ("rad", _DEGREE),
    "rev": ("rad", _TURN),
    "turn": ("rad", _TURN),
    "turns": ("rad", _TURN),
    "rad/s": ("rad_s", 1.0),
    "mrad/s": ("rad_s", 1e-3),
    "deg/s": ("rad_s", _DEGREE),
    "dps": ("rad_s", _DEGREE),
    "°/s": ("rad_s", _DEGREE),
    "rpm": ("rad_s", _TURN / 60.0),
    "rev/s": ("rad_s", _TURN),
    "rps": ("rad_s", _TURN),
    "rad/s2": ("rad_s2", 1.0),
    "deg/s2": ("rad_s2", _DEGREE),
    "m/s2": ("m_s2", 1.0),
    "mm/s2": ("m_s2", 1e-3),
    "g": ("m_s2", _GRAVITY),
    "gee": ("m_s2", _GRAVITY),
    "mg": ("m_s2", _GRAVITY * 1e-3),
    "ug": ("m_s2", _GRAVITY * 1e-6),
    "gal": ("m_s2", 1e-2),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "µm": ("m", 1e-6),
    "inch": ("m", 0.0254),
    "m/s": ("m_s", 1.0),
    "mm/s": ("m_s", 1e-3),
    "nm": ("n_m", 1.0),  # as engineers write newton metres; nobody measures these rigs in nanometres
    "mnm": ("n_m", 1e-3),
    "knm": ("n_m", 1e3),
    "ncm": ("n_m", 1e-2),
    "n": ("n", 1.0),
    "kn": ("n", 1e3),
    "a": ("a", 1.0),
    "amp": ("a", 1.0),
    "ampere": ("a", 1.0),
    "ma": ("a", 1e-3),
    "v": ("v", 1.0),
    "volt": ("v", 1.0),
    "volts": ("v", 1.0),
    "mv": ("v", 1e-3),
    "px": ("px", 1.0),
    "pixel": ("px", 1.0),
    "hz": ("hz", 1.0),
    "strain": ("strain", 1.0),
    "ustrain": ("strain", 1e-6),
    "ue": ("strain", 1e-6),
    "µe": ("strain", 1e-6),
}


def normal(unit: str) -> str:
    """A unit in the spelling of UNITS: 'm/s^2', 'm·s⁻²', 'm_s2' are all 'm/s2'; 'N·m', 'N*m', 'n_m' are 'nm'."""
    text = unit.strip().strip("[](){}").strip().lower().replace("μ", "µ").replace("²", "2").replace("⁻", "-")
    text = text.replace("^", "").replace("**", "").replace("{", "").replace("}", "")
    for mark in ("·", "*", " ", ".", "_"):
        text = text.replace(mark, "·")
    text = text.strip("·")
    spelt = {"n·m": "nm", "mn·m": "mnm", "n·cm": "ncm", "m/s/s": "m/s2", "m/sec2": "m/s2", "rad/sec": "rad/s"}
    spelt |= {"deg/sec": "deg/s", "degrees/s": "deg/s", "m·s-2": "m/s2", "rad·s-1": "rad/s", "m·s2": "m/s2"}
    spelt |= {
        "rad·s": "rad/s",
        "rad·s2": "rad/s2",
        "deg·s": "deg/s",
        "deg·s2": "deg/s2",
        "m·s": "m/s",
        "mm·s": "mm/s",
    }
    return spelt.get(text, text)


def size_of(unit: str) -> tuple[str, float] | None:
    """The dimension of a unit and its size in SI; None for one that is not known."""
    return UNITS.get(normal(unit))
