"""Furniture that was moved from its place on the map, and what is tied to it."""

from types import SimpleNamespace

import numpy as np
import pytest
from pinocchio import SE3
from synthetic_room import MAP as ROOM
from synthetic_room import SURFACES, Robot, displaced

from behaviours import Region
from behaviours.sensing.localiser import ExactLocaliser
from behaviours.sensing.moved_furniture import Furniture
from perception.registration import Displacement, Judge, register
from robots import Box, Geom

TOP = Geom(Box((0.6, 0.3, 0.015)), SE3(np.eye(3), np.array([1.0, 2.0, 0.5])), "table/top")
POST = Geom(Box((0.05, 0.05, 0.5)), SE3(np.eye(3), np.array([3.0, 0.0, 0.5])), "post")
MAP = (TOP, POST)
BY = np.array([0.05, -0.02, np.deg2rad(3.0)])


def seen(furniture: Furniture, by: np.ndarray, times: int = 1, sigma=(0.004,) * 3) -> None:
    """Registrations that show the table moved, or, if that is not noticeable, perhaps in place."""
    covariance = np.diag(np.square(sigma))
    one = Displacement(piece="table", centre=np.array([1.0, 2.0]), by=by, covariance=covariance)
    some = (one,) if np.linalg.norm(by) > 4.0 * min(sigma) else ()
    for _ in range(times):
        furniture.note(SimpleNamespace(displaced=some, uncertain=() if some else (one,)))


def test_a_displacement_that_persists_moves_the_piece_and_only_that():
    furniture = Furniture()
    seen(furniture, BY, times=2)
    assert furniture.names == ["table"]  # no pose rests on it from now on
    assert furniture.standing(MAP) is MAP
    seen(furniture, BY, times=8)
    top, post = furniture.standing(MAP)
    assert post is POST
    np.testing.assert_allclose(top.pose.translation, [1.05, 1.98, 0.5], atol=0.002)
    turn = np.arctan2(top.pose.rotation[1, 0], top.pose.rotation[0, 0])
    assert turn == pytest.approx(BY[2], abs=0.002)


def test_fixtures_are_the_same_tuple_until_the_piece_moves_noticeably():
    furniture = Furniture()
    seen(furniture, BY, times=30)
    before = furniture.standing(MAP)
    seen(furniture, BY + np.array([0.002, 0.0, 0.0]), times=30)
    assert furniture.standing(MAP) is before
    seen(furniture, BY + np.array([0.01, 0.0, 0.0]), times=30)
    assert furniture.standing(MAP) is not before


def test_a_piece_that_is_back_in_its_place_is_forgotten():
    furniture = Furniture()
    seen(furniture, BY, times=20)
    assert furniture.motion("table") is not None
    seen(furniture, np.zeros(3), times=40)
    assert furniture.names == []
    assert furniture.standing(MAP) is MAP


def test_what_one_view_does_not_show_is_kept_from_another():
    furniture = Furniture()
    seen(furniture, BY, times=20)
    seen(furniture, BY * [0.0, 1.0, 1.0], times=20, sigma=(0.0599, 0.004, 0.01))  # blind along x
    assert furniture.motion("table").act(TOP.pose.translation)[0] == pytest.approx(1.05, abs=0.005)


def test_a_place_moves_with_the_piece_that_it_is_on():
    here = ExactLocaliser()
    here.oTm = SE3(np.eye(3), np.array([0.1, 0.0, 0.0]))
    mTr = SE3(np.eye(3), np.array([1.0, 2.0, 0.6]))
    tied, free = (
        Region(name="r", mTr=mTr, size=np.ones(3), on=on, frame=here) for on in ("table", "")
    )
    seen(here.furniture, BY, times=20)
    np.testing.assert_allclose(free.oTr.translation, [1.1, 2.0, 0.6])
    np.testing.assert_allclose(tied.oTr.translation, [1.15, 1.98, 0.6], atol=0.002)
    here.furniture.forget()
    assert tied.oTr.isApprox(free.oTr)


def test_laser_and_camera_find_where_a_table_stands_by_now():
    by = np.array([0.03, 0.05, np.deg2rad(3.0)])
    world = {**ROOM, "near table": displaced(ROOM["near table"], by)}
    rng, mTb, furniture = np.random.default_rng(2), np.array([-0.6, 0.2, 0.1]), Furniture()
    robot, prior = Robot(rng), np.diag(np.square([0.01, 0.01, np.deg2rad(0.5)]))
    judge = Judge()
    for _ in range(12):
        clouds = [robot.scan(world, mTb), robot.image(world, mTb)]
        expected = mTb + rng.multivariate_normal(np.zeros(3), prior)
        moved = furniture.names
        result = register(SURFACES, clouds, expected, prior, moved=moved, judge=judge)
        furniture.note(result)
    top = ROOM["near table"][0].pose
    found = furniture.motion("near table") * top
    stands = world["near table"][0].pose
    assert np.linalg.norm(found.translation - stands.translation) < 0.01
    assert furniture.names == ["near table"]
