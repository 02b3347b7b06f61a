"""Thresholds of a region's map, on pictures of which every pixel is a millimetre."""

from collections.abc import Callable
from math import hypot
from types import SimpleNamespace

import numpy as np
import pytest
from pinocchio import SE3

from hw import DepthFrame
from perception import RegionMap
from perception.registration import Place
from robots import Intrinsics

HEIGHT, CELL = 2.0, 0.003
INNER = np.array([32, 24])
"""Cells of the region, without what is too near to its sides."""
SIZE = np.array([*(INNER * CELL + 2 * 0.008 - 1e-9), 0.2])
CAMERA = Intrinsics(width=180, height=160, fx=2000.0, fy=2000.0, cx=89.5, cy=79.5)
REGION = SE3(np.eye(3), np.array([1.0, 2.0, 0.6]))
FLOOR = REGION.translation - [0.0, 0.0, 0.1]
ABOVE = SE3(np.diag([1.0, -1.0, -1.0]), FLOOR + np.array([0.0, 0.0, HEIGHT]))
Heights = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Of x and y in the region [cells from its lower corner]; NaN is not measured."""


def frame(heights: Heights) -> DepthFrame:
    v, u = np.indices((CAMERA.height, CAMERA.width))
    x, y = 0.001 * (u - CAMERA.cx), 0.001 * (CAMERA.cy - v)
    cells = heights(x / CELL + INNER[0] / 2, y / CELL + INNER[1] / 2)
    depth = (HEIGHT - np.broadcast_to(cells, x.shape)).astype(np.float32)
    return DepthFrame(depth=depth, intrinsics=CAMERA, oTc=ABOVE, stamp=0.0)


def seen(
    heights: Heights, tolerance: float = 0.0, floor: float = 0.0, sure: float = 0.0, **options
) -> RegionMap:
    """The map of one picture, and where it shows the region: so exactly, the floor so high [m]."""
    shown = RegionMap(REGION, SIZE, stride=options.pop("stride", 1), **options)
    place = Place(REGION, np.full(2, tolerance), floor, sure, 0.01)
    shown.add(frame(heights), place)
    return shown


def box(x: float, y: float, wide: float, long: float, high: float, around: float = 0.0) -> Heights:
    """So high between these cells, of so many cells [m]."""

    def heights(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        inside = (i >= x) & (i < x + wide) & (j >= y) & (j < y + long)
        return np.where(inside, high, around)

    return heights


def flat(high: float) -> Heights:
    return box(0, 0, 0, 0, 0.0, around=high)


def hole(x: float, y: float, wide: float, long: float) -> Heights:
    return box(x, y, wide, long, np.nan)


def at(*cells: float) -> np.ndarray:
    """(3,) on the floor, in the world [m]."""
    return FLOOR + np.append(CELL * (np.array(cells) - INNER / 2), 0.0)


def areas(shown: RegionMap, smallest: float = 0.0) -> list[int]:
    """Of the objects [cells]."""
    return [round(one.area / CELL**2) for one in shown.segments(smallest)]


def test_an_object_is_where_it_is_and_as_large():
    (one,) = seen(box(4, 6, 10, 5, 0.02)).segments(0.0)
    assert one.area == pytest.approx(50 * CELL**2)
    np.testing.assert_allclose(one.centre, at(9.0, 8.5), atol=1e-5)
    usual = RegionMap(REGION, SIZE)
    usual.add(frame(box(4, 6, 10, 5, 0.02)))
    assert areas(usual) == [50]
    both = seen(lambda i, j: box(4, 6, 10, 5, 0.02)(i, j) + box(20, 6, 4, 4, 0.02)(i, j))
    assert sorted(areas(both)) == [16, 50]
    assert areas(both, 17 * CELL**2) == areas(both, 50 * CELL**2) == [50]
    known = SimpleNamespace(contains=lambda points: points[:, 0] < REGION.translation[0])
    assert [round(one.area / CELL**2) for one in both.segments(0.0, beside=[known])] == [16]


@pytest.mark.parametrize(
    ("x", "tolerance", "counts"),
    [
        (-2, 0.0, False),  # nearer than 8 mm to a side: it may be the wall
        (0, 0.0, True),
        (-2, 0.01, True),  # or stand inside, where the region is not known better
        (-6, 0.05, True),
        (-9, 0.05, False),  # but not more than 2 cm
    ],
)
def test_what_is_at_a_side_is_left_out_unless_the_region_may_be_there(x, tolerance, counts):
    assert bool(areas(seen(box(x, 6, 2, 5, 0.02), tolerance))) is counts


@pytest.mark.parametrize(
    ("height", "is_there"), [(0.0014, False), (0.0027, True), (0.195, True), (0.205, False)]
)
def test_so_high_is_an_object(height, is_there):
    shown = seen(box(4, 6, 6, 6, height))
    assert shown.lowest == pytest.approx(0.0025)
    assert bool(areas(shown)) is is_there
    assert (shown.seen < 1.0) is (height > 0.2)


@pytest.mark.parametrize(
    ("side", "height", "is_there"),
    [(5, 0.0017, True), (5, 0.0013, False), (4, 0.0022, False), (4, 0.0024, True)],
)
def test_what_is_lower_is_an_object_if_it_fills_a_window(side, height, is_there):
    assert bool(areas(seen(box(8, 8, side, side, height)))) is is_there


@pytest.mark.parametrize(("depth", "is_seen"), [(0.029, True), (0.031, False)])
def test_what_is_far_below_the_floor_is_not_seen(depth, is_seen):
    assert (seen(box(4, 6, 10, 10, -depth)).seen == 1.0) is is_seen


@pytest.mark.parametrize(
    ("height", "sure", "is_object", "floor"),
    [
        (0.0045, 0.0, False, 0.0045),  # the map may be wrong by 5 mm
        (0.0055, 0.0, True, 0.0),
        (0.0125, 0.012, False, 0.0125),  # and the picture about the region
        (0.0135, 0.012, True, 0.0),
        (0.0145, 0.1, False, 0.0145),
        (0.0155, 0.1, True, 0.0),  # no floor is so much higher
    ],
)
def test_what_covers_all_of_the_floor_is_an_object_if_the_floor_cannot_be_so_high(
    height, sure, is_object, floor
):
    for expected in (0.0, 0.003):
        shown = seen(flat(height + expected), floor=expected, sure=sure)
        assert areas(shown) == ([768] if is_object else [])
        assert shown.floor == pytest.approx(FLOOR[2] + floor + expected, abs=1e-5)
        least = hypot(sure, 0.005)
        assert shown.cover == pytest.approx(least + 0.01 + (0.0 if is_object else height), abs=1e-5)
    lower = seen(flat(-0.004), sure=sure)
    assert lower.floor == pytest.approx(FLOOR[2] - 0.004, abs=1e-5)
    assert lower.cover == pytest.approx(least + 0.01)


@pytest.mark.parametrize(("rows", "floor"), [(20, 0.003), (14, 0.0)])
def test_so_much_of_a_floor_has_to_be_seen_to_know_its_height(rows, floor):
    """Fifty cells, after three rounds of which each leaves the lower half."""

    def noisy(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        rough = np.random.default_rng(0).normal(0.0, 1e-5, i.shape)
        return box(0, 0, rows, 24, 0.003, around=np.nan)(i, j) + rough

    assert seen(noisy).floor == pytest.approx(FLOOR[2] + floor, abs=5e-5)


def test_the_floor_is_tilted_as_the_picture_shows_it_and_most_of_it_may_be_covered():
    assert areas(seen(lambda i, j: 0.04 * CELL * (i - 16 + j - 12))) == []
    assert areas(seen(box(7, 0, 18, 24, 0.008))) == [18 * 24]


def test_an_object_is_higher_than_six_deviations_of_the_floor():
    def rough(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return 0.0006 * (-1.0) ** (np.floor(i) + np.floor(j))

    assert seen(rough).lowest == pytest.approx(0.0036, rel=0.01)
    noise = np.random.default_rng(1).normal(0.0, 0.002, (160, 180))
    assert seen(lambda i, j: noise).lowest == pytest.approx(6 * 0.002 / 3, rel=0.1)


def test_what_is_between_measured_cells_is_seen_and_holes_are_not():
    assert [round(768 * (1.0 - seen(hole(8, 8, n, n)).seen)) for n in (1, 2, 3, 4)] == [0, 0, 0, 12]
    (part,) = seen(hole(12, 9, 5, 5)).hidden(0.0)
    np.testing.assert_allclose(part.centre, at(14.5, 11.5), atol=CELL + 1e-5)


@pytest.mark.parametrize(
    ("wide", "cells", "is_hidden"), [(9, 9, True), (9, 10, False), (5, 5, True), (5, 6, False)]
)
def test_a_narrow_gap_hides_nothing_wide(wide, cells, is_hidden):
    """However it is turned, it covers a disc."""
    for gap in (hole(12, 9, wide, 12), lambda i, j: hole(9, 12, wide, 12)(j, i)):
        assert bool(seen(gap).hidden(0.0, (cells + 0.1) * CELL)) is is_hidden


@pytest.mark.parametrize(
    ("x", "wide", "is_hidden"),
    [(0, 5, True), (3, 3, False), (3, 5, True), (9, 3, True), (9, 1, False)],
)
def test_a_narrow_strip_hides_something_unless_it_is_at_a_side(x, wide, is_hidden):
    """Within 25 mm, where walls hide it from one imager: then less than 4 cells."""
    for strip in (hole(x, 0, wide, 24), lambda i, j: hole(x, 0, wide, 32)(j, i)):
        assert bool(seen(strip).hidden(0.0)) is is_hidden


@pytest.mark.parametrize(("side", "gap", "count"), [(6, 1, 1), (6, 3, 2), (5, 3, 0), (8, 3, 2)])
def test_pieces_with_hardly_a_gap_may_be_one_and_small_ones_parts(side, gap, count):
    """Of less than 3 cm², and by one cell or two."""

    def two(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return box(4, 8, side, side, 0.02)(i, j) + box(4 + side + gap, 8, side, side, 0.02)(i, j)

    assert len(seen(two).pieces) == count
    assert len(areas(seen(two))) == 2


def test_before_the_first_picture_nothing_is_seen_and_the_floor_is_where_it_is_told():
    unseen = RegionMap(REGION, SIZE)
    assert (unseen.seen, unseen.lowest, unseen.floor) == (0.0, np.inf, pytest.approx(FLOOR[2]))
    (part,) = unseen.hidden(0.0)
    np.testing.assert_allclose(part.centre, FLOOR, atol=CELL)
    assert part.area == pytest.approx(INNER.prod() * CELL**2)


def test_every_pixel_has_its_turn():
    """Of two rows and columns: what one of four shows alone is seen in the fourth frame."""

    def quarter(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        v, u = np.indices(i.shape)
        return np.where((v % 2 == 1) & (u % 2 == 0), 0.0, np.nan)

    shown = RegionMap(REGION, SIZE)
    for number in range(1, 5):
        shown.add(frame(quarter))
        assert (shown.seen > 0.5) is (number == 4)
    assert shown.frames == 4


def test_a_picture_that_shows_the_floor_elsewhere_than_another_one_shows_nothing_on_it():
    """The mount of the camera is wrong, not the same in each view."""
    shown = RegionMap(REGION, SIZE, stride=1)
    for first, wide, floor in ((-9, 99, 0.0), (10, 12, 0.006)):
        one = box(first, -9, wide, 99, floor, around=np.nan)
        shown.add(frame(one), Place(REGION, np.zeros(2), floor, 0.001, 0.01))
    assert areas(shown) == []
    assert shown.seen == 1.0


@pytest.mark.parametrize("tolerances", [(0.009, 0.001), (0.001, 0.009)])
def test_a_wall_in_a_picture_that_hardly_tells_where_it_is_is_no_object_if_another_one_tells(
    tolerances,
):
    shown = RegionMap(REGION, SIZE, stride=1)
    for tolerance in tolerances:
        wall = box(INNER[0] + 1, -5, 9, 99, 0.06)
        shown.add(frame(wall), Place(REGION, np.full(2, tolerance), 0.0, 0.001, 0.01))
    assert areas(shown) == []


def test_two_parts_of_what_has_a_hole_between_may_be_one_object():
    def halves(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Of 4 cells each, 8 apart; and an object that stands alone."""
        body = box(4, 4, 16, 8, 0.02)(i, j) + box(24, 16, 4, 4, 0.02)(i, j)
        return np.where(hole(8, 4, 8, 8)(i, j) == 0.0, body, np.nan)

    shown = seen(halves)
    assert len(shown.segments(0.0)) == 3
    assert shown.fewest(0.0) == 2
    assert shown.fewest(20 * CELL**2) == 1
