"""Terms of free form: finite columns of the right shape, and forces that do what the simulation says they do."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.freeform import DRIVE, Group, _memory, groups, knots_over, pieces_over
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

PEAKS = (7.0, 24.0)
ALL = groups(PEAKS)
ONLY = {
    "reading": {"acceleration"},
    "reading_curves": {"acceleration"},
    "turning": {"acceleration"},
    "image": {"displacement"},
    "scale": {"displacement"},
    "scale_bends": {"displacement"},
    "scale_wanders": {"displacement"},
}


@pytest.fixture(scope="module")
def plain() -> Fit:
    """The baseline on data with nothing wrong."""
    return fitted(measured(6.0, 1))


@pytest.fixture(scope="module")
def unseen(plain: Fit) -> Fit:
    """The same without the joint's sensors."""
    nothing = np.full(plain.world.measured.cycles, np.nan)
    data = replace(plain.world.measured, position=nothing, velocity=nothing)
    assert not {"joint_position", "joint_velocity"} & set(World(data, MODEL).channels)
    return fitted(data)


def named(name: str) -> Group:
    return next(one for one in ALL if one.name == name)


def test_each_group_has_a_name_of_its_own() -> None:
    assert len({one.name for one in ALL}) == len(ALL) == 15 + 2 * len(PEAKS)
    assert len({one.words for one in ALL}) == len(ALL)


@pytest.mark.parametrize("group", ALL, ids=lambda one: one.name)
def test_its_columns_are_finite_and_of_its_channels_length(group: Group, plain: Fit, unseen: Fit) -> None:
    plain = unseen if group is DRIVE else plain
    found = group.added(plain)
    assert found is not None
    assert found.columns
    for name, columns in found.columns.items():
        assert columns.shape == (len(plain.world.channels[name]), len(found.amounts))
        assert np.isfinite(columns).all()
    # each column moves the channel that shows it most by that one's noise
    sizes = [np.sqrt(np.mean(one**2, axis=0)) / plain.sigma[name] for name, one in found.columns.items()]
    if group.prior_std is None:
        assert np.max(sizes, axis=0) == pytest.approx(np.ones(len(found.amounts)))
    own = ONLY.get(group.name)
    if group.name.startswith("image_rings"):
        own = {"displacement"}
    if group.name.startswith("sensor_rings"):
        own = {"acceleration"}
    assert set(found.columns) == (own or {"acceleration", "displacement"})


@pytest.mark.slow
@pytest.mark.parametrize("group", ALL, ids=lambda one: one.name)
def test_its_amounts_take_part_in_a_world(group: Group, plain: Fit, unseen: Fit) -> None:
    """What an amount adds to a channel is its column, and nothing else."""
    plain = unseen if group is DRIVE else plain
    added = group.added(plain)
    assert added is not None
    world = plain.world.changed(added=(added,))
    start = world.space.vector()
    for name in plain.world.space.place:
        start[world.space.place[name]] = plain.value(name)
    base = world.predict(start).channels
    shown = world.predict(world.space.with_values(start, {added.amounts[-1]: 2.0})).channels
    for name in base:
        more = shown[name] - base[name]
        wanted = 2.0 * added.columns[name][:, -1] if name in added.columns else np.zeros(len(more))
        assert np.nan_to_num(more) == pytest.approx(wanted, abs=1e-9 * (1.0 + np.max(np.abs(wanted))))


def moved(plain: Fit, name: str, by: float) -> dict[str, np.ndarray]:
    """What a change of a quantity does to each channel."""
    world, vector = plain.world, plain.vector
    other = world.space.with_values(vector, {name: plain.value(name) + by})
    after, before = world.predict(other).channels, world.predict(vector).channels
    return {one: after[one] - before[one] for one in ("acceleration", "displacement")}


def unclipped(plain: Fit, name: str) -> np.ndarray:
    """Where a channel is within its sensor's range."""
    return np.abs(plain.predicted.channels[name]) < (19.5 if name == "acceleration" else np.inf)


def test_a_force_over_the_deflection_is_a_stiffness(plain: Fit) -> None:
    """A course that is a straight line, -e w^2 q, raises the frequency by e / 2: as the simulation shows it."""
    hz, share = plain.value("modes.0.frequency_hz"), 2e-5
    q = plain.predicted.motion.q[:, 0]
    line = -share * knots_over(q)
    wanted = moved(plain, "modes.0.frequency_hz", 0.5 * share * hz)
    for name, columns in named("position").columns(plain).items():
        if name in wanted:
            off = (columns @ line - wanted[name])[unclipped(plain, name)]
            assert np.std(off) < 0.02 * np.std(wanted[name]), name


def test_a_bend_learnt_of_most_swings_is_foretold_of_a_larger_one() -> None:
    """A gain that falls off with size; one blow, half as large again, that nothing was learnt of: pieces that
    end there foretell nothing of it."""
    time = np.arange(0.0, 20.0, 0.001)
    swing = np.exp(-0.1 * time) * np.sin(9.0 * time)
    swing[12_000:12_700] *= 5.0
    bent, learnt = swing - 0.3 * swing * np.abs(swing), np.abs(swing) < 0.9
    courses = pieces_over(swing)
    amounts = np.linalg.lstsq(courses[learnt], bent[learnt], rcond=None)[0]
    off = (courses @ amounts - bent)[~learnt]
    assert np.max(np.abs(swing[~learnt])) > 1.3
    assert np.max(np.abs(off)) < 0.3 * np.max(np.abs(bent))


def test_a_quantity_at_rest_has_courses_all_the_same() -> None:
    assert np.isfinite(pieces_over(np.zeros(50))).all()


def test_a_force_over_the_velocity_is_a_damping(plain: Fit) -> None:
    """-2 dz w q'."""
    hz, more = plain.value("modes.0.frequency_hz"), 2e-5
    v = np.gradient(plain.predicted.motion.q[:, 0], 0.001)
    line = -2.0 * more / (2.0 * np.pi * hz) * knots_over(v)
    wanted = moved(plain, "modes.0.damping_ratio", more)
    for name, columns in named("velocity").columns(plain).items():
        if name in wanted:
            off = (columns @ line - wanted[name])[unclipped(plain, name)]
            assert np.std(off) < 0.02 * np.std(wanted[name]), name


def test_a_force_that_wanders_alike_throughout_is_a_stiffness_and_a_damping(plain: Fit) -> None:
    """Its hats, all alike, sum up to one."""
    wander, position = named("wander").columns(plain), named("position").columns(plain)
    q = plain.predicted.motion.q[:, 0]
    line = knots_over(q) / np.max(np.abs(q))
    for name, columns in wander.items():
        assert columns[:, :7].sum(axis=1) == pytest.approx(position[name] @ line, rel=1e-9, abs=1e-6)


def test_an_image_scale_that_changes_alike_throughout_is_a_scale(plain: Fit) -> None:
    wanted = moved(plain, "camera.scale_px_per_m", 0.01 * plain.value("camera.scale_px_per_m"))[
        "displacement"
    ]
    shown = named("scale").columns(plain)["displacement"].sum(axis=1)
    assert np.corrcoef(shown, wanted)[0, 1] > 0.99999


def test_a_force_with_a_memory_lags_behind_the_deflection(plain: Fit) -> None:
    """A play's loop takes energy: what it pushes with, less what follows, works against the motion."""
    q = plain.predicted.motion.q[:, 0]
    kept = _memory(plain)
    top = np.max(np.abs(q))
    for i, share in enumerate((0.02, 0.06, 0.15, 0.4)):
        assert np.max(np.abs(kept[:, i])) <= share * top * (1.0 + 1e-9)
        assert float(np.sum(kept[1:, i] * np.diff(q))) > 0.0


def test_a_joint_that_is_slower_one_way_turns_the_arm_and_shakes_it(unseen: Fit) -> None:
    """A course over its speed that is a straight line to one side: as the simulation moves by such commands."""
    world, less = unseen.world, 0.004
    measured = world.measured
    slower = replace(measured, command=np.where(measured.command < 0.0, 1.0 - less, 1.0) * measured.command)
    moved = World(slower, MODEL).predict(unseen.vector).channels
    omega = unseen.predicted.motion.joint[:, 1]
    knots = np.array([-1.0, -0.7, -0.35, -0.03, 0.03, 0.35, 0.7, 1.0])
    line = -less * np.max(np.abs(omega)) * np.where(knots < 0.0, knots, 0.0)
    for name, columns in DRIVE.columns(unseen).items():
        if name in moved:
            wanted = moved[name] - unseen.predicted.channels[name]
            off = (columns @ line - wanted)[unclipped(unseen, name)]
            # an accelerometer shows a jump of the speed in a cycle of its own
            assert np.std(off) < {"acceleration": 0.1}.get(name, 0.02) * np.std(wanted), name


def test_a_joint_with_sensors_tells_itself_what_it_did(plain: Fit) -> None:
    assert DRIVE.added(plain) is None


def test_a_peak_that_the_grid_cannot_show_is_not_tried(plain: Fit) -> None:
    rings = [one for one in groups((450.0,)) if "rings" in one.name]
    assert rings and all(one.added(plain) is None for one in rings)


def test_a_channel_that_was_not_measured_has_no_structure(plain: Fit) -> None:
    data = replace(plain.world.measured, acceleration=np.full(6000, np.nan))
    blind = fitted(data)
    assert named("reading").added(blind) is None
    assert named("turning").added(blind) is None
    found = named("position").added(blind)
    assert found is not None and set(found.columns) == {"displacement"}


def test_an_image_scale_that_drifts_along_a_line_is_told_by_two_numbers(plain: Fit) -> None:
    """Beside the scale itself, which the baseline has."""
    columns = named("scale_bends").columns(plain)["displacement"]
    swing = plain.predicted.channels["displacement"] - plain.value("camera.offset_px")
    drifts = plain.world.measured.frames.received_s * swing
    told = np.concatenate([columns, swing[:, None]], axis=1)
    assert columns.shape[1] == 2
    assert np.linalg.lstsq(told, drifts, rcond=None)[1] == pytest.approx(
        0.0, abs=1e-9 * float(drifts @ drifts)
    )
