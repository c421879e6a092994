"""How the parts of a rig are connected: the picture of the tutorial."""

from pathlib import Path

BOXES = {
    "camera": (20, 20, 180, 64, "camera", "sees the scene from the tip"),
    "sensor": (20, 190, 180, 64, "accelerometer", "at the tip"),
    "supervisor": (290, 20, 200, 64, "supervisor's computer", "stillarm supervisor"),
    "controller": (290, 190, 200, 64, "controller's computer", "stillarm controller"),
    "drive": (650, 190, 180, 64, "drive and motor", "at the joint"),
    "stop": (650, 300, 180, 52, "emergency stop", "cuts the motor's power"),
}
"""x, y, width, height, title, text."""
WIRES = (
    ("camera", "supervisor", "USB or CSI", "right"),
    ("sensor", "controller", "I2C, 400 kHz, under 1 m", "right"),
    ("controller", "drive", "CAN, USB or UDP", "right"),
    ("supervisor", "controller", "Ethernet, its own network", "down"),
    ("stop", "drive", "wire", "up"),
)


def draw(path: Path) -> None:
    """docs/images/wiring.svg"""
    parts = [_box(*box) for box in BOXES.values()] + [_wire(*wire) for wire in WIRES]
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 850 370" font-family="sans-serif" font-size="13">\n'
        '<rect width="850" height="370" fill="#ffffff"/>\n'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0 L8 4 L0 8 z" fill="#4c72b0"/></marker></defs>\n' + "\n".join(parts) + "\n</svg>\n"
    )


def _box(x: int, y: int, width: int, height: int, title: str, text: str) -> str:
    middle = x + width // 2
    return (
        f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="8" fill="#eef3f8" stroke="#4c72b0"/>'
        f'<text x="{middle}" y="{y + height // 2 - 4}" text-anchor="middle" font-weight="bold">{title}</text>'
        f'<text x="{middle}" y="{y + height // 2 + 15}" text-anchor="middle" fill="#555555">{text}</text>'
    )


def _wire(begin: str, end: str, label: str, way: str) -> str:
    x0, y0, w0, h0, *_ = BOXES[begin]
    x1, y1, w1, h1, *_ = BOXES[end]
    if way == "right":
        ends = (x0 + w0, y0 + h0 // 2, x1 - 2, y1 + h1 // 2)
        place, anchor = ((ends[0] + ends[2]) // 2, ends[1] - 10), "middle"
        if len(label) > 16:
            place = (ends[0], ends[1] + 54)
            anchor = "start"
    else:
        down = way == "down"
        ends = (x0 + w0 // 2, y0 + h0 if down else y0, x1 + w1 // 2, y1 - 2 if down else y1 + h1 + 2)
        place, anchor = (ends[0] + 8, (ends[1] + ends[3]) // 2 + 4), "start"
    line = '<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="#4c72b0" stroke-width="2" marker-end="url(#tip)"/>'
    return line.format(*ends) + f'<text x="{place[0]}" y="{place[1]}" text-anchor="{anchor}">{label}</text>'
