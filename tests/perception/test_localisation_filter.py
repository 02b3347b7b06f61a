"""The transform from odometry to the map, against a base whose errors are known."""

from itertools import pairwise, product

import numpy as np
import pytest
from synthetic_room import MAP, SURFACES, Robot, displaced

from config.planar import compose, inverse
from perception.registration import LocalisationFilter, Registration, Surfaces, register, smoothed

SIGMA = np.array([0.02, 0.02, np.deg2rad(0.5)])
READING = np.diag(SIGMA) ** 2
FAR = np.array([40.0, -30.0, 2.0])
"""Odometry that started far from the map's origin."""
SLIPPED = np.array([0.08, -0.05, np.deg2rad(2.0)])
CARRIED = np.array([0.5, -0.4, np.deg2rad(10.0)])


class Base:
    """A base that drives about: where it is, and what its odometry and its localisation say."""

    def __init__(self, seed: int, *, slip: float = 0.03, tau: float = 5.0) -> None:
        self.rng = np.random.default_rng(seed)
        self.robot, self.tau, self.t = Robot(self.rng), tau, 0.0
        self.mTb, self.goal = self.rng.uniform((-1, -0.8, -0.5), (-0.2, 0.8, 0.5), size=(2, 3))
        self.oTb = FAR
        self.factor = 1.0 + slip * self.rng.normal(size=3)
        self.error = self.rng.normal(size=3) * SIGMA
        self.world = {
            name: displaced(geoms, self.rng.normal(size=3) * [0.002, 0.002, np.deg2rad(0.1)])
            for name, geoms in MAP.items()
        }
        self.estimate = LocalisationFilter(self.reading(), READING, self.t, self.oTb)

    def reading(self) -> np.ndarray:
        return self.mTb + self.error

    def drive(self, dt: float, speed: float = 0.3) -> None:
        off = self.goal - self.mTb
        there = self.mTb + off * min(1.0, speed * dt / max(np.linalg.norm(off), 1e-9))
        step, self.mTb = compose(inverse(self.mTb), there), there
        self.oTb = compose(self.oTb, step * self.factor)
        kept = np.exp(-dt / self.tau)
        noise = np.sqrt(1.0 - kept**2) * self.rng.normal(size=3) * SIGMA
        self.error = kept * self.error + noise
        self.t += dt
        self.estimate.travelled(self.oTb)

    def localise(self) -> bool:
        return self.estimate.localised(self.reading(), READING, self.t, self.oTb).accepted

    def match(self, prior: np.ndarray, covariance: np.ndarray) -> Registration:
        scan = self.robot.scan(self.world, self.mTb, step=3)
        return register(SURFACES, [scan], prior, covariance)

    def register(self) -> bool:
        estimate, oTb = self.estimate, self.oTb
        result = self.match(estimate.pose(oTb), estimate.covariance(oTb))
        return estimate.registered(result, oTb).accepted

    def settle(self) -> None:
        for _ in range(3):
            self.drive(0.2)
            self.localise()
            self.register()

    def off(self) -> np.ndarray:
        return self.estimate.pose(self.oTb) - self.mTb

    def nees(self) -> float:
        """Per degree of freedom."""
        off = self.off()
        return float(off @ np.linalg.solve(self.estimate.covariance(self.oTb), off)) / 3.0


@pytest.mark.parametrize(("trials", "periods", "registering"), [(100, 20, False), (12, 10, True)])
def test_the_covariance_is_honest_and_registrations_leave_millimetres(trials, periods, registering):
    squares, errors, claimed = [], [], []
    for seed in range(trials):
        base = Base(seed)
        for _ in range(periods):
            base.drive(0.2)
            base.localise()
            assert not registering or base.register()
            squares.append(base.nees())
        errors.append(np.hypot(*base.off()[:2]))
        claimed.append(np.sqrt(base.estimate.covariance(base.oTb)[0, 0]))
    assert 0.5 < np.mean(squares) < 2.0
    if registering:
        assert np.median(errors) < 0.006
        assert max(claimed) < 0.006


def test_a_hundred_readings_in_a_second_are_worth_one():
    base = Base(0)
    before = base.estimate.covariance(base.oTb)
    for _ in range(100):
        base.drive(0.01, speed=0.0)
        assert base.localise()
    after = base.estimate.covariance(base.oTb)
    assert np.sqrt(after[0, 0]) > 0.8 * np.sqrt(before[0, 0])


def test_driving_makes_it_less_certain_and_standing_does_not():
    base = Base(1)
    base.register()
    before = base.estimate.covariance(base.oTb)
    base.drive(1.0, speed=0.0)
    assert base.estimate.covariance(base.oTb) == pytest.approx(before)
    base.drive(1.0)
    assert (np.diag(base.estimate.covariance(base.oTb)) > np.diag(before)).all()


@pytest.mark.parametrize(("way", "error"), [(0.5, 0.019), (2.0, 0.069), (10.0, 0.227)])
def test_wheels_that_slip_alike_are_explained(way, error):
    base = Base(1)
    estimate, ahead = base.estimate, np.array([0.05, 0.0, 0.0])
    base.register()
    _, _, heading = estimate.pose(base.oTb)
    along = np.array([np.cos(heading), np.sin(heading), 0.0])
    before = along @ estimate.covariance(base.oTb) @ along
    for _ in range(round(way / 0.05)):
        base.oTb = compose(base.oTb, ahead)
        estimate.travelled(base.oTb)
    grown = along @ estimate.covariance(base.oTb) @ along - before
    assert np.sqrt(grown) == pytest.approx(error, rel=0.05)


def test_a_slip_that_lasts_is_compensated():
    errors: dict[bool, list[float]] = {True: [], False: []}
    for seed, is_registered in product(range(8), (True, False)):
        base = Base(seed)
        base.factor = np.full(3, 1.05)
        for _ in range(40 if is_registered else 0):
            base.drive(0.1)
            base.register()
        before, base.goal = base.off(), base.mTb + np.array([0.5, 0.0, 0.0])
        base.drive(2.0)
        errors[is_registered].append(np.hypot(*(base.off() - before)[:2]))
    assert np.mean(errors[True]) < 0.6 * np.mean(errors[False])


def test_a_slip_that_odometry_missed_is_found():
    base = Base(2)
    for _ in range(3):
        base.drive(0.2)
        base.register()
    base.mTb = base.mTb + SLIPPED
    accepted = []
    for _ in range(15):
        base.drive(0.2, speed=0.0)
        base.localise()
        accepted.append(base.register())
    assert not accepted[0]
    assert all(accepted[-3:])
    assert np.hypot(*base.off()[:2]) < 0.01


@pytest.mark.parametrize("carried", [True, False], ids=["base carried", "localisation wrong"])
def test_a_relocalisation_is_taken_over_if_the_scan_agrees(carried):
    base = Base(3)
    base.settle()
    before = base.mTb
    if carried:
        base.mTb = base.mTb + CARRIED
    else:
        base.error = base.error + CARRIED
    base.tau = 1e9
    taken = []
    for _ in range(10):
        base.drive(0.2, speed=0.0)
        assert not base.localise() or any(taken)
        here = base.match(base.estimate.pose(base.oTb), base.estimate.covariance(base.oTb))
        base.estimate.registered(here, base.oTb)
        if proposal := base.estimate.proposal(base.oTb):
            there = base.match(*proposal)
            taken.append(base.estimate.relocalised(there, here, base.oTb))
    assert any(taken) is carried
    assert len(taken) == 1 or not carried
    assert taken
    assert np.hypot(*base.off()[:2]) < 0.02
    assert base.mTb[0] == pytest.approx(before[0] + 0.5 * carried)


@pytest.mark.parametrize(("in_place", "suspected"), [(0, {"near table"}), (20, set())])
def test_a_table_alone_in_sight_is_suspected_unless_it_stood_in_its_place(in_place, suspected):
    base = Base(2)
    base.settle()
    alone = Surfaces({"near table": MAP["near table"]})
    off = {"near table": displaced(MAP["near table"], [0.05, 0.0, np.deg2rad(3.0)])}
    moved: set[str] = set()
    for number in range(in_place + 10):
        base.drive(0.2, speed=0.0 if number < in_place else 0.3)
        base.localise()
        estimate, oTb = base.estimate, base.oTb
        prior = estimate.pose(oTb), estimate.covariance(oTb)
        world = MAP if number < in_place else off
        seen = [base.robot.scan(world, base.mTb), base.robot.image(world, base.mTb)]
        moved |= estimate.registered(register(alone, seen, *prior, moved=moved), oTb).moved
    assert moved == suspected
    assert in_place or np.hypot(*base.off()[:2]) < 0.02


def insisting(seconds: float, *, sees: bool) -> Base:
    """A base whose own localisation has been wrong for a time [s]."""
    base = Base(4)
    base.settle()
    base.error, base.tau = base.error + CARRIED, 1e9
    for number in range(round(seconds / 0.1)):
        base.drive(0.1, speed=0.0)
        base.localise()
        estimate, oTb = base.estimate, base.oTb
        if sees and number % 5 == 0 and (proposal := estimate.proposal(oTb)):
            here = base.match(estimate.pose(oTb), estimate.covariance(oTb))
            assert not estimate.relocalised(base.match(*proposal), here, oTb)
    return base


def test_what_the_base_insists_on_is_a_doubt_until_points_refute_it():
    assert insisting(1.3, sees=False).estimate.doubt is None
    off, turn = insisting(2.0, sees=False).estimate.doubt
    assert off == pytest.approx(np.hypot(*CARRIED[:2]), abs=0.1)
    assert turn == pytest.approx(CARRIED[2], abs=0.05)
    base = insisting(3.0, sees=True)
    assert base.estimate.doubt is None
    assert np.hypot(*base.off()[:2]) < 0.02


def test_a_doubt_is_over_when_the_base_says_so_or_nothing():
    base = insisting(2.0, sees=False)
    base.error = base.error - CARRIED
    base.drive(0.1, speed=0.0)
    assert base.localise()
    assert base.estimate.doubt is None
    base = insisting(2.0, sees=False)
    base.estimate.unlocalised()
    assert base.estimate.doubt is None


def test_what_nothing_refutes_for_long_is_taken_over():
    base = insisting(4.5, sees=False)
    assert not base.estimate.carried(base.oTb)
    base = insisting(5.5, sees=False)
    assert base.estimate.carried(base.oTb)
    assert base.estimate.doubt is None
    assert base.off() == pytest.approx(base.error, abs=1e-9)
    base = insisting(6.5, sees=True)
    assert not base.estimate.carried(base.oTb)


def test_a_correction_never_makes_a_step_at_the_base():
    mTb = np.array([1.0, 2.0, 0.5])
    applied, newest = compose(mTb, inverse(FAR)), compose(mTb + SLIPPED, inverse(FAR))
    poses = [mTb]
    for _ in range(100):
        applied = smoothed(applied, newest, FAR, 0.01)
        poses.append(compose(applied, FAR))
    steps = np.array([b - a for a, b in pairwise(poses)])
    assert np.hypot(steps[:, 0], steps[:, 1]).max() <= 0.2 * 0.01 + 1e-9
    assert np.abs(steps[:, 2]).max() <= np.deg2rad(12.0) * 0.01 + 1e-9
    assert poses[-1] == pytest.approx(mTb + SLIPPED, abs=1e-9)
