"""Assumptions about forces that no sensor measures: random and lasting ones."""

from dataclasses import dataclass

from stillarm.controller.estimation.fused.assumptions.origin import TRIED, assumed


@dataclass(frozen=True, slots=True)
class RandomForceAssumptions:
    """A steady random force (learnt_force.py)."""

    rate: float = assumed(0.06, "of the intensity's logarithm, an image", TRIED)
    usual_nis: float = assumed(
        1.1, "innovation squared", "chosen: a little above its mean of 1, so that it sinks"
    )
    largest_nis: float = assumed(16.0, "innovation squared", "derived: four standard deviations")
    floor: float = assumed(
        1e-4, "of an image's variance, a second", "chosen: chance does not lift it from there"
    )
    matters: float = assumed(0.03, "of an image's variance, a second", TRIED)
    most: float = assumed(1e6, "of an image's variance, a second", "bound: within the range of floats")
    scatter_blocks: float = assumed(60.0, "blocks", "derived: two and a half periods")
    largest_scatter: float = assumed(4.0, "times the mean", "chosen: an impact is in one block")
    shown_share: float = assumed(
        0.25, "of the intensity learnt", "chosen: what the accelerometer shows of a random force, at least"
    )
    shown_noise: float = assumed(
        0.15, "of the sensor's own variance", "chosen: less is chance, or a noise not known better"
    )
    first_images: int = assumed(65, "images", "derived: a second")


@dataclass(frozen=True, slots=True)
class HeldForceAssumptions:
    """A force that lasts (held_force.py)."""

    span_s: float = assumed(0.1, "s", "derived: about a capture delay, over which it is extrapolated")
    onset_s: float = assumed(
        0.05, "s", "chosen: over a few frames an innovation grows until it leaves its gate"
    )
    rest_share: float = assumed(1.0, "of an image's variance, a second", TRIED)
    gate_stds: float = assumed(3.0, "standard deviations", "derived: a smaller force may be none")
    none_for_s: float = assumed(1.0, "s", TRIED)
    at_rest: float = assumed(4.0, "times the walk of a force that rests", TRIED)
    odds_of_none: float = assumed(20.0, "odds", "chosen: strong evidence (Kass and Raftery, JASA 90, 1995)")
    reversals: int = assumed(3, "reversals, each within about half a period", TRIED)
    short_s: float = assumed(1.5, "s", TRIED)
    short_again_s: float = assumed(8.0, "s", TRIED)
    not_again_s: float = assumed(2.0, "s", TRIED)
    pull_stds: float = assumed(5.5, "standard deviations of a mean", "derived: by chance once in a day")
    largest_stds: float = assumed(4.0, "standard deviations", "chosen: one wrong image is no pull")
    fewest_frames: float = assumed(6.0, "frames", TRIED)
    followed: float = assumed(3.0, "of the zero's variance", TRIED)
    zero_periods: float = assumed(
        4.0, "half periods", "chosen: so long a pull goes on before it is significant"
    )
    first_stds: float = assumed(
        2.0, "standard deviations of an image", "chosen: a slow pull, when it is noticed"
    )
    zero_known: float = assumed(1.0, "of an image's variance", TRIED)
    by_wrong_dates: float = assumed(2.0, "of the amplitude", "derived: a vibration shown half a period late")
