"""Registration in a room whose furniture stands up to a few millimetres beside the map."""

from itertools import product

import numpy as np
import pytest
from pinocchio import SE3, exp3
from synthetic_room import MAP, SURFACES, Pieces, Robot, box, displaced

from perception.registration import Cloud, Judge, Registration, Surfaces, register, scan_cloud
from perception.registration.matching import Problem, Solution
from robots import Box, Capsule, Cylinder, Geom, Sphere, hull_of, load_robot

PRIOR = np.diag([0.04, 0.04, np.deg2rad(1.5)]) ** 2
BY = np.array([0.03, 0.04, np.deg2rad(3.0)])


def built(rng: np.random.Generator, pieces: Pieces = MAP) -> Pieces:
    """The world that a map is of: good to 2 mm and 0.1 degrees."""
    return {
        name: displaced(geoms, rng.normal(size=3) * [0.002, 0.002, np.deg2rad(0.1)])
        for name, geoms in pieces.items()
    }


def somewhere(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform((-1.0, -0.8, -0.5), (-0.2, 0.8, 0.5))


def cluttered(cloud: Cloud, share: float, rng: np.random.Generator) -> Cloud:
    """Something stands before the surface for a share of the points."""
    shorter = np.where(rng.random(len(cloud.points)) < share, rng.uniform(0.5, 1.0), 1.0)
    points = cloud.eye + (cloud.points - cloud.eye) * shorter[:, None]
    return Cloud(points, cloud.eye, cloud.errors)


def judged(surfaces: Surfaces, clouds: list[Cloud], expected: np.ndarray) -> Registration:
    """The registration with which the verdict on the furniture comes, or the last of ten."""
    judge = Judge()
    results = [register(surfaces, clouds, expected, PRIOR, judge=judge) for _ in range(10)]
    return next((one for one in results if one.displaced or one.uncertain), results[-1])


def trials(count, sensors, pieces=MAP, clutter=0.0) -> tuple[np.ndarray, list[Registration]]:
    """Errors (count, 3) and results; each trial has its own robot, room and place."""
    rng, errors, results = np.random.default_rng(1), [], []
    for _ in range(count):
        robot, world, mTb = Robot(rng), built(rng, pieces), somewhere(rng)
        clouds = [robot.scan(world, mTb)] if "laser" in sensors else []
        clouds += [robot.image(world, mTb)] if "camera" in sensors else []
        clouds = [cluttered(cloud, clutter, rng) for cloud in clouds]
        expected = mTb + rng.multivariate_normal(np.zeros(3), PRIOR)
        results.append(judged(SURFACES, clouds, expected))
        errors.append(results[-1].pose - mTb)
    return np.array(errors), results


def nees(errors: np.ndarray, results: list[Registration]) -> float:
    """Mean, per degree of freedom."""
    squares = [e @ np.linalg.solve(r.covariance, e) for e, r in zip(errors, results, strict=True)]
    return float(np.mean(squares)) / 3.0


@pytest.mark.parametrize(
    ("sensors", "clutter", "median", "yaw_deg"),
    [
        ("laser and camera", 0.0, 0.005, 0.1),
        ("laser", 0.0, 0.005, 0.1),
        ("camera", 0.0, 0.015, 0.6),
        ("laser and camera", 0.3, 0.005, 0.15),
    ],
)
def test_four_centimetres_become_millimetres(sensors, clutter, median, yaw_deg):
    errors, results = trials(12, sensors, clutter=clutter)
    assert np.median(np.hypot(errors[:, 0], errors[:, 1])) < median
    assert np.rad2deg(np.median(np.abs(errors[:, 2]))) < yaw_deg
    assert 0.2 < nees(errors, results) < 2.0
    assert not any(result.displaced for result in results)


def test_many_points_of_a_camera_do_not_claim_millimetres():
    robot, mTb = Robot(np.random.default_rng(4)), np.array([-0.6, 0.2, 0.1])
    image = robot.image(MAP, mTb)
    many = Cloud(np.repeat(image.points, 20, axis=0), image.eye, image.errors)
    deviation = np.sqrt(np.diag(register(SURFACES, [many], mTb, PRIOR).covariance))
    assert deviation[:2].min() > 0.003
    assert deviation[2] > np.deg2rad(0.4)


def test_a_flat_wall_says_nothing_along_itself():
    wall = {"wall": [box((0.1, 60.0, 2.5), (2.05, 0.0, 1.25))]}
    rng = np.random.default_rng(2)
    scan = Robot(rng).scan(wall, np.zeros(3))
    prior = np.array([0.03, 0.03, np.deg2rad(1.0)])
    result = register(Surfaces(wall), [scan], prior, PRIOR)
    assert abs(result.pose[0]) < 0.01
    assert abs(result.pose[2]) < np.deg2rad(0.3)
    assert result.pose[1] == pytest.approx(0.03, abs=0.002)
    assert np.sqrt(result.covariance[1, 1]) == pytest.approx(0.04, rel=0.01)
    assert np.sqrt(result.covariance[0, 0]) < 0.005


@pytest.mark.parametrize("pieces", [{}, MAP])
@pytest.mark.parametrize("clouds", [0, 1])
def test_with_nothing_in_sight_the_prior_stays(pieces, clouds):
    far = Robot(np.random.default_rng(0)).scan(MAP, np.zeros(3))
    far = Cloud(far.points + np.array([50.0, 0.0, 0.0]), far.eye, far.errors)
    prior = np.array([0.1, 0.2, 0.3])
    result = register(Surfaces(pieces), [far] * clouds, prior, PRIOR)
    assert result.pose == pytest.approx(prior)
    assert result.covariance == pytest.approx(PRIOR)
    assert result.information == pytest.approx(np.zeros((3, 3)), abs=1e-3)
    assert result.mahalanobis == pytest.approx(0.0)
    assert result.explained == 0.0


def test_a_table_that_was_moved_is_found_and_left_out():
    moved = {**MAP, "near table": displaced(MAP["near table"], BY)}
    errors, results = trials(20, "laser and camera", moved)
    assert np.median(np.hypot(errors[:, 0], errors[:, 1])) < 0.005
    assert nees(errors, results) < 2.0
    found = [piece for result in results for piece in result.displaced]
    assert {piece.piece for piece in found} == {"near table"}
    assert len(found) > 10
    for piece in found:
        off = piece.by - BY
        assert off @ np.linalg.solve(piece.covariance, off) < 25.0


def test_no_registration_makes_more_than_one_trial(monkeypatch):
    moved = {**MAP, "near table": displaced(MAP["near table"], BY)}
    robot, mTb, judge = Robot(np.random.default_rng(4)), np.array([-0.6, 0.2, 0.1]), Judge()
    clouds, solve, solved = [robot.scan(moved, mTb), robot.image(moved, mTb)], Problem.solve, []

    def counted(problem: Problem, loose: frozenset[int]) -> Solution:
        solved.append(loose)
        return solve(problem, loose)

    monkeypatch.setattr(Problem, "solve", counted)
    found, costs = [], []
    for _ in range(len(MAP) + 2):
        solved.clear()
        result = register(SURFACES, clouds, mTb, PRIOR, judge=judge)
        found += [piece.piece for piece in result.displaced]
        costs.append(len(solved))
    assert found == ["near table"]
    assert max(costs) == 2


def test_of_one_piece_alone_a_displacement_is_taken_for_a_pose_error():
    alone = {"near table": MAP["near table"]}
    moved = {"near table": displaced(MAP["near table"], np.array([0.05, 0.0, 0.0]))}
    rng = np.random.default_rng(3)
    robot, mTb = Robot(rng), np.array([-0.3, 0.2, 0.0])
    clouds = [robot.scan(moved, mTb), robot.image(moved, mTb)]
    wide = judged(Surfaces(alone), clouds, mTb)
    assert wide.consistent
    assert wide.displaced == ()
    assert wide.pose[0] - mTb[0] == pytest.approx(-0.05, abs=0.015)
    assert not register(Surfaces(alone), clouds, mTb, PRIOR / 100.0).consistent


def test_of_two_pieces_that_contradict_each_other_none_is_believed():
    pieces = {name: MAP[name] for name in ("near table", "pedestal")}
    moved = {**pieces, "near table": displaced(pieces["near table"], BY)}
    robot, mTb = Robot(np.random.default_rng(3)), np.array([-0.6, 0.6, 0.2])
    clouds = [robot.scan(moved, mTb), robot.image(moved, mTb)]
    result = judged(Surfaces(pieces), clouds, mTb)
    error = result.pose - mTb
    assert error @ np.linalg.solve(result.covariance, error) < 16.0
    assert result.uncertain or {piece.piece for piece in result.displaced} <= {"near table"}


def test_what_stands_on_something_is_one_stack_with_it():
    bin_on_top = [box((0.3, 0.3, 0.1), (0.9, 1.5, 0.65))]
    surfaces = Surfaces({**MAP, "bin": bin_on_top}, fixed={"walls"})
    stacks = dict(zip(surfaces.names, surfaces.stacks.tolist(), strict=True))
    assert stacks["bin"] == stacks["pedestal"]
    assert len(set(stacks.values())) == len(MAP)


def test_points_that_are_not_numbers_are_left_out():
    robot, mTb = Robot(np.random.default_rng(4)), np.array([-0.6, 0.2, 0.1])
    scan = robot.scan(MAP, mTb)
    holes = Cloud(np.concatenate([np.full((5, 3), np.nan), scan.points]), scan.eye, scan.errors)
    results = [register(SURFACES, [cloud], mTb + 0.01, PRIOR) for cloud in (scan, holes)]
    assert results[0].pose == pytest.approx(results[1].pose, abs=1e-9)


def test_a_beam_is_through_what_the_map_has_there_if_it_meets_nothing_not_if_it_tells_nothing():
    laser, post = load_robot("frankie").laser, box((0.1, 0.1, 1.0), (1.5, 0.0, 0.5))
    for told, is_through in ((np.inf, True), (np.nan, False), (1.0, False)):
        ranges = np.full(len(laser.angles), told)
        cloud = scan_cloud(ranges, laser.points(ranges), laser)
        through = Surfaces({"post": [post]}).missed(np.zeros(3), cloud)[0]
        assert bool(through.sum()) is is_through


def test_the_jacobian_is_that_of_the_distances():
    robot, mTb = Robot(np.random.default_rng(5)), np.array([-0.6, 0.2, 0.1])
    pieces = {**MAP, "column": displaced(MAP["column"], np.zeros(3))}
    clouds = [robot.scan(pieces, mTb), robot.image(pieces, mTb)]
    problem = Problem(Surfaces(pieces), clouds, mTb, PRIOR)
    x = np.zeros(problem.n)
    start = problem.matched(x)
    for unknown in range(problem.n):
        step = np.zeros(problem.n)
        step[unknown] = 1e-6
        ahead, back = (problem.matched(x + s, start.tries).residuals for s in (step, -step))
        numeric = (ahead - back) / 2e-6
        wrong = np.abs(numeric - start.J[:, unknown]) > 1e-4
        assert wrong.mean() < 0.01, unknown  # those at an edge


TILTED = SE3(exp3(np.array([0.3, -0.5, 0.7])), np.array([0.1, 0.2, 0.3]))


@pytest.mark.parametrize(
    "shape", [Sphere(0.2), Capsule(0.1, 0.3), Cylinder(0.2, 0.3), Box((0.1, 0.2, 0.3))]
)
def test_a_point_moved_by_its_distance_against_its_normal_lies_on_the_surface(shape):
    surfaces = Surfaces({"piece": [Geom(shape, TILTED)]})
    points = TILTED.translation + np.random.default_rng(1).normal(size=(200, 3)) * 0.3
    which = np.zeros(200, dtype=int)
    d, n, _ = surfaces.distances(points, which, points)
    on, _, _ = surfaces.distances(points - d[:, None] * n, which, points)
    assert (d < 0.0).any()
    assert on == pytest.approx(0.0, abs=1e-9)


def test_inside_a_hull_the_nearest_face_counts():
    cube = hull_of(np.array(list(product((0.0, 0.4), repeat=3))))
    point = np.array([[0.05, 0.2, 0.2]])
    d, n, _ = Surfaces({"cube": [cube]}).distances(point, np.zeros(1, dtype=int), point)
    assert d == pytest.approx([-0.05])
    assert n[0] == pytest.approx([-1.0, 0.0, 0.0])


def test_a_point_behind_a_thin_wall_is_measured_from_its_front():
    surfaces = Surfaces({"wall": [box((0.05, 4.0, 2.0), (2.025, 0.0, 1.0))]})
    points, eyes = np.array([[2.12, 0.3, 0.5]]), np.array([[0.0, 0.0, 0.2]])
    d, n, seen = surfaces.distances(points, np.zeros(1, dtype=int), eyes)
    assert d == pytest.approx([-0.12])
    assert n[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert seen.all()
