"""How wrong a simulated robot is about where it is: levels, odometry, localised poses, mounts."""

from itertools import pairwise
from math import inf

import numpy as np
import pinocchio as pin
import pytest
from harness import SIMULATORS
from pinocchio import SE3

from config import UserError
from config.reader import ConfigError
from controller import Command
from hw import SimClock, WorldOptions, find_world, open_backend
from hw.sim import (
    LEVELS,
    Localisation,
    LocalisationProcess,
    load_localisation,
    load_scene,
    simulated_robot,
)
from hw.sim.levels import Misplacement, Odometry, Outages, PoseError, Steps
from robots import load_robot

TWIST = np.array([0.5, 0.0, 0.2])


def truth(time: float) -> SE3:
    """The pose of a base that drives an arc."""
    vx, vy, w = TWIST * time
    return pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))


def readings(level: Localisation, stamps: np.ndarray, seed: int = 0) -> list:
    process = LocalisationProcess(level, np.random.default_rng(seed))
    return [process.read(stamp, truth(stamp)) for stamp in stamps.tolist()]


def yaw(pose: SE3) -> float:
    return float(np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0]))


def test_an_exact_level_changes_and_draws_nothing():
    rng = np.random.default_rng(5)
    process = LocalisationProcess(LEVELS["exact"], rng)
    here = truth(1.0)
    assert process.read(1.0, here) == (here, None)
    assert process.read(1.0, here)[0] is here
    assert rng.random() == np.random.default_rng(5).random()


def test_the_same_seed_gives_the_same_bits_however_often_it_is_read():
    level = LEVELS["poor"].model_copy(update={"outages": Outages(interval=3.0, duration=0.5)})
    stamps = np.arange(0.0, 20.0, 0.01)
    once = readings(level, stamps)
    twice = readings(level, np.arange(0.0, 20.0, 0.005))[::2]
    seldom = readings(level, stamps[::7])
    for (oTb, localised), (same, again) in zip(once, twice, strict=True):
        assert np.array_equal(oTb.homogeneous, same.homogeneous)
        assert (localised is None) == (again is None)
        if localised is not None:
            assert localised.stamp == again.stamp
            assert np.array_equal(localised.mTb.homogeneous, again.mTb.homogeneous)
    for (oTb, localised), (same, again) in zip(once[::7], seldom, strict=True):
        assert oTb.isApprox(same, 1e-9)
        assert localised is again is None or localised.mTb.isApprox(again.mTb, 1e-9)
    other = readings(level, stamps, seed=1)
    assert not other[-1][0].isApprox(once[-1][0], 1e-6)


def test_odometry_begins_exact_and_drifts_without_a_jump():
    level = LEVELS["poor"]
    stamps = np.arange(0.0, 30.0, 0.003)
    oTb = [pose for pose, _ in readings(level, stamps)]
    assert oTb[0].isApprox(truth(0.0), 1e-12)
    steps = [pin.log6(a.actInv(b)).vector for a, b in pairwise(oTb)]
    told = np.array(steps)[:, [0, 1, 5]] / 0.003
    assert np.abs(told / np.where(TWIST, TWIST, 1.0) - (TWIST != 0.0)).max() < 0.3  # 5 sigma
    assert np.linalg.norm(oTb[-1].translation - truth(stamps[-1]).translation) > 0.01
    standing = LocalisationProcess(level, np.random.default_rng(0))
    for stamp in np.arange(0.0, 10.0, 0.01):
        assert standing.read(stamp, truth(3.0))[0].isApprox(truth(3.0), 1e-9)


def test_slip_is_a_share_of_the_way_and_drift_a_turn_for_each_metre():
    odometry = Odometry(slip=0.03, turn_slip=0.1, drift_deg=0.5)
    level = Localisation(odometry=odometry, localisation=PoseError(time_constant=1e5))
    lengths, turns = [], []
    for seed in range(400):
        (_, (oTb, _)) = readings(level, np.array([0.0, 0.01]), seed)
        v, _, w = pin.log6(oTb).vector[[0, 1, 5]] / 0.01
        lengths.append(v / TWIST[0] - 1.0)
        turns.append(w - TWIST[2])
    assert np.std(lengths) == pytest.approx(0.03, rel=0.15)
    wanted = np.hypot(0.1 * TWIST[2], np.deg2rad(0.5) * TWIST[0])
    assert np.std(turns) == pytest.approx(wanted, rel=0.15)


@pytest.mark.parametrize("process", ["gauss_markov", "bounded_walk"])
def test_the_localised_pose_is_as_wrong_as_its_covariance_and_forgets_with_the_time_constant(
    process,
):
    error = PoseError(sigma=0.02, sigma_deg=0.5, time_constant=0.25, process=process)
    level = Localisation(localisation=error)
    stamps = np.arange(0.0, 100.0, 0.1)
    errors = []
    for _, localised in readings(level, stamps):
        true = truth(localised.stamp)
        turn = yaw(true.actInv(localised.mTb))
        errors.append([*(localised.mTb.translation - true.translation)[:2], turn])
    errors = np.array(errors)
    sigma = np.sqrt(np.diag(localised.covariance))
    np.testing.assert_allclose(sigma, [0.02, 0.02, np.deg2rad(0.5)])
    np.testing.assert_allclose(errors.std(axis=0), sigma, rtol=0.12)
    kept = [np.corrcoef(column[:-3], column[3:])[0, 1] for column in errors.T]
    np.testing.assert_allclose(kept, np.exp(-1.2), atol=0.1)
    tails = np.abs(errors) > 3.0 * sigma
    assert tails.any() == (process == "gauss_markov")


def test_localised_poses_come_ten_times_a_second_and_keep_still_between():
    seen = []
    for _, localised in readings(LEVELS["good"], np.arange(0.0, 1.001, 0.02)):
        if not seen or localised is not seen[-1]:
            seen.append(localised)
    np.testing.assert_allclose([one.stamp for one in seen], np.arange(0.0, 1.01, 0.1), atol=1e-9)


def test_relocalisations_are_steps_of_their_size_about_as_often_as_said():
    level = Localisation(
        localisation=PoseError(time_constant=1e5), steps=Steps(size=0.08, interval=1.0)
    )
    stamps = np.arange(0.0, 100.0, 0.1)
    off = [
        localised.mTb.translation - truth(localised.stamp).translation
        for _, localised in readings(level, stamps)
    ]
    jumps = np.linalg.norm(np.diff(off, axis=0), axis=1)
    sizes = jumps[jumps > 0.01]
    assert 70 < len(sizes) < 130
    assert np.mean(np.abs(sizes - 0.08) < 0.001) > 0.85  # two may fall into one


def test_in_an_outage_there_is_no_localised_pose():
    level = Localisation(
        localisation=PoseError(sigma=0.01), outages=Outages(interval=5.0, duration=1.0)
    )
    lost = [localised is None for _, localised in readings(level, np.arange(0.0, 100.0, 0.1))]
    assert 0.1 < np.mean(lost) < 0.3
    ends = np.flatnonzero(np.diff(lost))
    assert np.diff(ends)[::2].min() == 10


@pytest.mark.parametrize("world", SIMULATORS)
def test_wheels_of_a_simulated_robot_slip_and_it_believes_what_it_measures(world):
    level = LEVELS["good"].model_copy(update={"depth_scale": 0.1})

    def after(localisation: Localisation | None):
        clock, described = SimClock(), load_robot("frankie")
        truth = load_scene("single", 0)
        robot = simulated_robot(
            find_world(world).body(), described, truth, clock, seed=4, localisation=localisation
        )
        with robot:
            for _ in range(100):
                state = robot.read()
                robot.send(Command(base_twist=np.array([0.2, 0.0, 0.1]), qd=np.zeros(7)))
                clock.sleep_until(clock.now() + 0.01)
            return state, robot.camera.latest(inf), robot._base, robot._arm.body

    exact, straight, base, body = after(LEVELS["exact"])
    plain, _, _, _ = after(None)
    assert np.array_equal(exact.oTb.homogeneous, plain.oTb.homogeneous)
    assert base.read().localised is None
    wrong, scaled, base, other = after(level)
    assert wrong.oTb.isApprox(exact.oTb, 1e-4), "odometry tells what the wheels did"
    off = np.abs(wrong.base_twist - exact.base_twist).max()
    assert off < 1e-4, "which turn as commanded, so no limit is passed"
    assert not other.wTb.isApprox(body.wTb, 1e-5), "and they slip"
    assert other.wTb.isApprox(body.wTb, 0.02)
    assert base.read().localised.stamp == pytest.approx(1.0)
    seen = np.isfinite(straight.depth) & np.isfinite(scaled.depth)
    ratio = float(np.median(scaled.depth[seen] / straight.depth[seen]))
    assert abs(ratio - 1.0) == pytest.approx(0.1, abs=0.02)
    believed, true = load_robot("frankie").camera.eTc, other.description.camera.eTc
    miss = believed.actInv(true)
    assert np.linalg.norm(miss.translation) == pytest.approx(0.003)
    assert np.linalg.norm(pin.log3(miss.rotation)) == pytest.approx(np.deg2rad(0.5))


def test_levels_come_by_name_or_from_a_file_whose_mistakes_have_their_place(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("localisation: {sigma: 0.03}\nhand_eye: {offset: 0.002}\n")
    mine = load_localisation(str(path))
    assert mine.localisation.sigma == 0.03
    assert mine.hand_eye == Misplacement(offset=0.002)
    assert not mine.exact
    assert load_localisation("exact").exact
    with pytest.raises(ConfigError, match=r"`god`; did you mean `good`\?"):
        load_localisation("god")
    path.write_text("localisation: {sigma: 0.03}\nsteps: {size: 0.1, intervall: 60}\n")
    with pytest.raises(ConfigError, match=r"mine.yaml:2:20: steps.intervall: unknown key; did you"):
        load_localisation(str(path))
    path.write_text("localisation: {sigma: -1}\n")
    with pytest.raises(ConfigError, match=r"mine.yaml:1:23: localisation.sigma: expected a number"):
        load_localisation(str(path))
    path.write_text("localisation: {sigma: 0.02, process: walk}\n")
    with pytest.raises(
        ConfigError, match=r"mine.yaml:1:38: localisation.process: expected `gauss_"
    ):
        load_localisation(str(path))
    with pytest.raises(ConfigError, match="did you mean"):
        open_backend("frankie", "kinematic", WorldOptions(scene="single", localisation="pour"))


def test_furniture_is_moved_with_what_stands_on_it_and_the_map_is_not(tmp_path):
    plain = load_scene("household", 0)
    world = load_scene("household", 0, moved={"container": (0.05, 0.0, 3.0)})
    assert [one.pose for one in world.mapped] == [one.pose for one in plain.mapped]
    before, after = ({one.name: one.pose for one in each.fixtures} for each in (plain, world))
    motion = after["container/floor"] * before["container/floor"].inverse()
    assert yaw(motion) == pytest.approx(np.deg2rad(3.0))
    assert after["table/top"] == before["table/top"]
    for obj, other in zip(world.objects, plain.objects, strict=True):
        assert obj.pose.isApprox(motion * other.pose)
    assert world.supports() == plain.supports()
    path = tmp_path / "moved.yaml"
    path.write_text("moved: {tabel: [0.05, 0, 3]}\n")
    options = WorldOptions(scene="single", localisation=str(path))
    with pytest.raises(UserError, match="`tabel`; did you mean `table`"):
        open_backend("frankie", "kinematic", options)
