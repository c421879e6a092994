"""The moving picture of the README: the demo's arm, struck and ringing, struck again and damped, as an animated SVG.

The deflection is the simulated rig's true one, drawn some 40 times as large. SMIL moves it: no script, so that a
page may show the file as a picture.
"""

from pathlib import Path

import numpy as np
from runs import demo_run

FROM_S, TO_S = 1.0, 24.0
FRAMES_A_SECOND = 30
WIDTH, HEIGHT = 800, 330
HUB_X, HUB_Y, TIP_X = 60.0, 105.0, 560.0
TRACE = (60.0, 720.0, 255.0, 55.0)  # left, right, middle and half height of the curve
LARGEST_M, TIP_PX = 0.0066, 70.0  # the largest deflection, and how far it is drawn
ARM_LENGTH_M = 2.0
STRIKES_S = (2.0, 18.0)  # of the demo's scenario


def draw(path: Path) -> None:
    """docs/images/stilled.svg"""
    run = demo_run()
    state = run.truth["truth_state"]
    time_s = np.arange(FROM_S, TO_S, 1.0 / FRAMES_A_SECOND)
    arm = np.interp(time_s, state["time_s"], state["deflection_m"]) / LARGEST_M
    fine_s = np.arange(FROM_S, TO_S, 0.01)
    fine = np.interp(fine_s, state["time_s"], state["deflection_m"]) / LARGEST_M
    lasts = f"{TO_S - FROM_S:g}s"
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">\n'
        f"<title>A flexible arm is struck and rings; struck again, it is damped through a late camera</title>\n"
        f'<rect width="{WIDTH}" height="{HEIGHT}" rx="8" fill="#ffffff"/>\n'
        f"{_arm(arm, lasts)}\n{_words(lasts)}\n{_trace(fine_s, fine, lasts)}\n</svg>\n"
    )


def _moving(attribute: str, values: list[str], lasts: str, mode: str = "linear") -> str:
    return (
        f'<animate attributeName="{attribute}" dur="{lasts}" repeatCount="indefinite" calcMode="{mode}" '
        f'values="{";".join(values)}"/>'
    )


def _arm(arm: np.ndarray, lasts: str) -> str:
    """Hub, bent beam and camera. A cubic whose two middle points lie on the axis and below the tip bends as a beam."""
    tip_y = [HUB_Y - TIP_PX * q for q in arm]
    beams = [
        f"M{HUB_X:g} {HUB_Y:g}C220 {HUB_Y:g} 400 {HUB_Y + 0.38 * (y - HUB_Y):.1f} {TIP_X:g} {y:.1f}"
        for y in tip_y
    ]
    shift = [f"0 {y - HUB_Y:.1f}" for y in tip_y]
    return (
        f'<path d="{beams[0]}" fill="none" stroke="#4c72b0" stroke-width="7" stroke-linecap="round">'
        f"{_moving('d', beams, lasts)}</path>"
        f'<circle cx="{HUB_X:g}" cy="{HUB_Y:g}" r="20" fill="#333333"/>'
        f'<g><animateTransform attributeName="transform" type="translate" dur="{lasts}" repeatCount="indefinite" '
        f'values="{";".join(shift)}"/>'
        f'<rect x="{TIP_X - 4:g}" y="{HUB_Y - 15:g}" width="36" height="30" rx="4" fill="#333333"/>'
        f'<circle cx="{TIP_X + 36:g}" cy="{HUB_Y:g}" r="9" fill="#888888"/></g>'
    )


def _words(lasts: str) -> str:
    """What happens, each shown from its time on."""
    texts = (
        (FROM_S, STRIKES_S[0], "at rest", "#555555"),
        (STRIKES_S[0], STRIKES_S[1], "struck: it rings", "#dd8452"),
        (STRIKES_S[1], TO_S, "struck again, damping on", "#55a868"),
    )
    span = TO_S - FROM_S
    shown = []
    for begin, end, text, colour in texts:
        first, last = (begin - FROM_S) / span, (end - FROM_S) / span
        times = f"0;{first:.4f};{min(last, 1.0):.4f};1" if first > 0 else f"0;{last:.4f};1"
        values = "0;1;0;0" if first > 0 else "1;0;0"
        shown.append(
            f'<text x="400" y="30" font-size="20" text-anchor="middle" fill="{colour}" opacity="0">{text}'
            f'<animate attributeName="opacity" dur="{lasts}" repeatCount="indefinite" calcMode="discrete" '
            f'keyTimes="{times}" values="{values}"/></text>'
        )
    return "".join(shown)


def _trace(time_s: np.ndarray, q: np.ndarray, lasts: str) -> str:
    """The deflection's course, uncovered as time passes."""
    left, right, middle, half = TRACE
    magnified = TIP_PX / LARGEST_M * ARM_LENGTH_M / (TIP_X - HUB_X)
    span = TO_S - FROM_S
    x = left + (right - left) * (time_s - FROM_S) / span
    points = " ".join(f"{a:.1f},{middle - half * b:.1f}" for a, b in zip(x, q, strict=True))
    marks = "".join(
        f'<line x1="{at:.0f}" x2="{at:.0f}" y1="{middle - half - 5:g}" y2="{middle + half + 5:g}" stroke="#dd8452" '
        f'stroke-dasharray="4 3"/>'
        for at in (left + (right - left) * (strike - FROM_S) / span for strike in STRIKES_S)
    )
    return (
        f'<line x1="{left:g}" x2="{right:g}" y1="{middle:g}" y2="{middle:g}" stroke="#cccccc"/>{marks}'
        f'<clipPath id="past"><rect x="{left:g}" y="0" width="0" height="{HEIGHT}">'
        f"{_moving('width', ['0', f'{right - left:g}'], lasts)}</rect></clipPath>"
        f'<polyline points="{points}" fill="none" stroke="#333333" stroke-width="1" clip-path="url(#past)"/>'
        f'<text x="{left:g}" y="{HEIGHT - 6}" font-size="13" fill="#555555">deflection of the tip over '
        f"{span:g} s; drawn above {magnified:.0f} times as large; camera 74 ms late</text>"
    )
