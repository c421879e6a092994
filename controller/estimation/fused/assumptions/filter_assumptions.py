"""Assumptions about the filters' prior, about how their knowledge ages, and about what they learn of that."""

from dataclasses import dataclass

from stillarm.controller.estimation.fused.assumptions.origin import TRIED, assumed


@dataclass(frozen=True, slots=True)
class StartAssumptions:
    """States at the start, their growth, and the laws' first odds (start.py)."""

    amplitude: float = assumed(0.02, "of the arm's length", TRIED)
    image_zero: float = assumed(0.05, "of the arm's length, about the first image", TRIED)
    scale: float = assumed(0.07, "relative", "chosen: another scene's depth")
    bias_m_s2: float = assumed(1.0, "m/s^2", "chosen: gravity on a sensor that is tilted by six degrees")
    decay_share: float = assumed(0.5, "of the nominal decay rate", TRIED)
    decay_w: float = assumed(0.002, "of the frequency", TRIED)
    skew: float = assumed(
        60e-6, "relative", "bound: two crystals, each some tens of ppm; 200 ppm is 3.4 deviations"
    )
    ahead_frames: float = assumed(
        1.0, "frames", "bound: n_i precedes mid-exposure by half a frame, one, or two"
    )
    late_share: float = assumed(0.5, "of the delay's spread, for the law drift", TRIED)
    stale_s: float = assumed(0.03, "s", "chosen: a first frame that has waited")
    stale_frames: float = assumed(0.5, "frames", "chosen: likewise")
    least_spread_s: float = assumed(0.002, "s", "chosen: of any capture delay, whatever the model says")
    steady_s: float = assumed(0.0003, "s, white spread of the law steady", TRIED)
    drift_s: float = assumed(0.0005, "s, white spread of the law drift", TRIED)
    clock_s: float = assumed(0.00002, "s, white spread of the law clock", TRIED)
    stamp_s: float = assumed(0.00004, "s, white spread of the law stamps", TRIED)
    clock_walk_s: float = assumed(1e-6, "s in a square root second", TRIED)
    steady_walk_s: float = assumed(3e-5, "s in a square root second", TRIED)
    jitter_walk_s: float = assumed(2e-4, "s in a square root second", TRIED)
    drift_return: float = assumed(0.35, "1/s", "chosen: the delay wanders over its spread in some seconds")
    disturbed: float = assumed(0.2, "probability", TRIED)
    disturbed_walk: float = assumed(150.0, "times the quiet level's walk of the frequency", TRIED)
    disturbed_share: float = assumed(22.0, "times the quiet level's share of the amplitude", TRIED)
    looser: float = assumed(2.0, "times the quiet level's walks of offset, scale and bias", TRIED)
    offset_walk: float = assumed(1e-5, "m in a square root second", TRIED)
    scale_walk: float = assumed(1e-4, "relative, in a square root second", TRIED)
    bias_walk_m_s2: float = assumed(0.015, "m/s^2 in a square root second", TRIED)
    decay_walk: float = assumed(0.000015, "of the frequency, in a square root second", TRIED)
    disturbed_decay_walk: float = assumed(0.006, "of the frequency, in a square root second", TRIED)
    freerun_clock: float = assumed(0.75, "probability of the clock for a free-running camera", TRIED)
    triggered_clock: float = assumed(0.1, "probability of the clock for a triggered camera", TRIED)


@dataclass(frozen=True, slots=True)
class UpdateAssumptions:
    """An image's or a block's correction, and what an image may tell (filters/, fusion/)."""

    vague: float = assumed(0.002, "of the squared rate", TRIED)
    shift_untold: float = assumed(0.25, "of a shift's first variance", TRIED)
    insignificant: float = assumed(
        0.1, "of the squared rate", "derived: three deviations; less of a rate is noise"
    )
    model_floor: float = assumed(0.002, "of the deflection", "bound: no image scale or model is better")
    image_huber_nis: float = assumed(12.0, "innovation squared", "derived: 3.5 standard deviations (Huber)")
    block_huber_nis: float = assumed(7.0, "innovation squared", "derived: 2.6 standard deviations (Huber)")
    blind_blocks: int = assumed(12, "blocks", "derived: half a period")
    bends_rad: float = assumed(0.15, "rad", "derived: linearised about it a sine is wrong by 1 %")
    before_cause_stds: float = assumed(
        3.0, "standard deviations", "derived: no frame is read before its exposure"
    )
    jitter_gain: float = assumed(0.01, "of a jitter's variance, a frame", TRIED)
    least_jitter: float = assumed(0.5, "of the first variance", TRIED)
    least_jitter_own: float = assumed(0.1, "of the first variance, for the law jitter", TRIED)
    still: float = assumed(0.02, "of the vibration's rate", "chosen: so slow a joint dates no image")
    unseen: float = assumed(
        0.001, "of an image's variance, a second", "chosen: the least that phasors wander"
    )
    clear: float = assumed(0.995, "probability", "chosen: the others no longer matter")
    sampled_cycles: float = assumed(
        0.4, "cycles", "derived: a sensor sampled some time within the last cycle"
    )
    telling_stds: float = assumed(3.0, "standard deviations of an image", "derived: a wrong count then shows")
    delay_known: float = assumed(0.2, "of a frame, standard deviation", TRIED)
    delay_gain: float = assumed(0.03, "of a delay, a frame", TRIED)
    least_delay_std_s: float = assumed(0.001, "s", "chosen: a cycle, in which arrivals are read")
    images_in_cycle: int = assumed(2, "images", "bound: no cycle may be long")
    dated_in_cycle: int = assumed(4, "frames", "measured: 0.1 to 0.25 ms each, and no cycle may be long")
    ahead_frames: float = assumed(0.9, "frames after an image, whose blocks are processed with it", TRIED)
    most_steps: int = assumed(4, "steps of a frame in a cycle", "bound: no cycle may be long")
    untold_frames: int = assumed(2, "frames in a row", "chosen: one now and then is told with the next")
    spare_cycles: float = assumed(0.45, "of the cycles that a frame has for steps", TRIED)
    delay_shown_stds: float = assumed(
        3.0, "standard deviations of the deflection", "derived: less may be none"
    )
    no_images_s: float = assumed(0.25, "s", "chosen: after so long the delay is held")


@dataclass(frozen=True, slots=True)
class WalkAssumptions:
    """How far quantities walk, learnt (learnt_walks.py)."""

    stretch_s: float = assumed(1.5, "s", TRIED)
    wander_stretch_s: float = assumed(0.25, "s", "chosen: a delay is seen to wander within a few frames")
    wander_rate: float = assumed(0.05, "of the share's logarithm, a stretch", TRIED)
    most_wander: float = assumed(30.0, "times the variance", "chosen: faster, within some frames, is white")
    least_share: float = assumed(0.04, "times the variance", "chosen: a fifth of the deviation")
    most_share: float = assumed(900.0, "times the variance", "chosen: thirty times the deviation")
    rate: float = assumed(0.6, "of the share's logarithm, a stretch", TRIED)
    largest_nis: float = assumed(9.0, "step squared over its variance", "derived: three standard deviations")
    least_expected: float = assumed(0.2, "of the walk's variance", "chosen: less was not measured")


@dataclass(frozen=True, slots=True)
class ScaleAssumptions:
    """The image's scale: stated, and drifting (stated_scale.py, scale_watch.py)."""

    by_hand: float = assumed(
        0.005, "relative", "chosen: a distance measured with a ruler; strangers' recordings lie within 0.4 %"
    )
    even_odds: float = assumed(1.0, "odds of a scale put in by hand", "chosen: nothing is known of it")
    commissioned_odds: float = assumed(
        9.0, "odds of a commissioned scale", "chosen: it was measured on this rig"
    )
    least: float = assumed(0.002, "relative", "measured: what `calibrate` comes to")
    told: float = assumed(0.5, "of the first variance", "chosen: above it sensors have said too little")
    settled: float = assumed(0.04, "of the stated variance", "chosen: below it the model adds nothing")
    memory_s: float = assumed(10.0, "s", TRIED)
    alarm: float = assumed(22.0, "score squared", "derived: 4.7^2, by chance once in fifty hours")
    soon_s: float = assumed(4.0, "s for as far again", TRIED)
    fade_s: float = assumed(20.0, "s", TRIED)
    room_stretch_s: float = assumed(0.5, "s between steps of the estimate", TRIED)
    least_room: float = assumed(
        1e-4, "of the room to walk", "chosen: what remains where the scale takes none"
    )
    most: float = assumed(
        0.3, "relative", "chosen: if only so much shows, the vibration is too small to tell"
    )
    bound: float = assumed(9.0, "innovation squared", "chosen: an impact or a spike may not decide alone")
