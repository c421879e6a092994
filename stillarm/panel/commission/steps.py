"""The steps of commissioning in the page's words, with what moves and how far. Pure."""

from typing import Any

from stillarm.diagnosis.commissioning.plan import Limits


def steps(allowed: Limits) -> list[dict[str, Any]]:
    """name, does, moves for each step. allowed: the limits within what the drive can do."""
    angle = f"{allowed.angle_rad:g} rad"
    velocity = f"{allowed.velocity_rad_s:g} rad/s"
    return [
        {
            "name": "Check",
            "does": "Asks the machine, the sensors, the camera, the link and the drive (`stillarm check`).",
            "moves": "Nothing moves.",
        },
        {
            "name": "Quiet",
            "does": "Listens for 3 s: noise of the sensors, bias of the accelerometer.",
            "moves": "The joint stands still.",
        },
        {
            "name": "Probe",
            "does": "Short moves to and fro of 0.1 s, each pair at twice the velocity of the last one, as long as "
            "every bound holds: frequency, damping, signs and scales, roughly.",
            "moves": f"From 0.004 rad/s up to at most {velocity}, within {angle} of where the joint is.",
        },
        {
            "name": "Moves",
            "does": "Pairs of half a period at three velocities; slowly to a pose and back; to and fro without a "
            "pause: participation, scales, drive, capture delay.",
            "moves": f"At most three quarters of {angle} and of {velocity}; "
            f"the image shifts by at most {allowed.image_px:g} px.",
        },
        {
            "name": "Ring-down and fit",
            "does": "Lets the arm ring for 8 to 30 s, fits the model, and judges whether it is good to damp by.",
            "moves": "The joint stands still.",
        },
    ]
