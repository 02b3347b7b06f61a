"""Scenes: worlds of the shipped files and of a user's files."""

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from pinocchio import SE3

from hw.sim import Hand, load_scene, read_scene, scene_names
from hw.sim.contact import separation
from hw.sim.objects import HOUSEHOLD, make_object
from hw.sim.scene import Scene
from hw.sim.scene_schema import Container, Fixture, Item, Motion, Objects, SideTable, Table, Walker
from robots import Geom, load_robot, reach

GOOD = """\
container:
  centre: [3.0, 0.0]
table:
  centre: [0.0, 1.6]
objects:
  count: 2
"""


def gap(one: list[Geom], other: list[Geom]) -> float:
    return min(separation(a, b)[0] for a in one for b in other)


def narrowest(parts: list[Geom]) -> float:
    """Smallest extent of any part across any horizontal direction [m]."""
    angles = np.linspace(0.0, np.pi, 180, endpoint=False)
    return min(
        reach(part, along) + reach(part, -along)
        for part in parts
        for along in np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    )


@pytest.mark.slow
def test_every_shipped_scene_has_room_for_its_objects():
    assert all(load_scene(name, 0).objects for name in scene_names())


def test_objects_lie_in_the_container_apart_from_each_other():
    world = load_scene("household", 1)
    walls = [f for f in world.fixtures if f.name == "container/wall"]
    for i, obj in enumerate(world.objects):
        parts = obj.placed()
        assert obj.reach(np.array([0.0, 0.0, -1.0])) == pytest.approx(-0.456)
        assert world.resting_on(obj) == "container"
        assert gap(parts, walls) >= 0.012
        assert all(gap(parts, other.placed()) >= 0.006 for other in world.objects[:i])
        x, y, _ = obj.pose.translation
        assert abs(x - 3.0) < 0.22
        assert abs(y) < 0.18
    assert len({obj.name for obj in world.objects}) == len(world.objects)


def test_every_household_class_can_be_grasped_by_every_part():
    rng = np.random.default_rng(7)
    for name in 5 * list(HOUSEHOLD):
        obj = make_object("it", HOUSEHOLD[name], (0.015, 0.07), (0.03, 0.5), rng)
        assert 0.015 - 1e-9 <= narrowest(obj.placed()) <= 0.07 + 1e-9


def test_the_same_seed_gives_the_same_world():
    first, again, other = (
        [pickle.dumps(one) for one in load_scene("household", seed).objects] for seed in (3, 3, 4)
    )
    assert first == again
    assert first != other


def test_container_table_and_fixtures_stand_where_the_scene_says(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        GOOD + "fixtures:\n  - {name: shelf, centre: [1, 1, 0.5], size: [1, 0.2, 0.02],"
        " yaw_deg: 90}\n"
        "  - {name: crate, centre: [1, 0, 0.2], size: [0.2, 0.2, 0.4], on_map: false}\n"
    )
    world = load_scene(path, 0)
    assert len(world.objects) == 2
    top = {f.name: reach(f, np.array([0.0, 0.0, 1.0])) for f in world.fixtures[1:]}
    assert top["table/top"] == pytest.approx(0.5)
    assert top["container/floor"] == pytest.approx(0.456)
    assert top["container/wall"] == pytest.approx(0.506)
    walls = [f.pose.translation[:2] for f in world.fixtures if f.name == "container/wall"]
    assert np.ptp(walls, axis=0) == pytest.approx([0.446, 0.366])
    shelf, crate = world.fixtures[-2:]
    assert (shelf.name, crate.name) == ("shelf", "crate")
    assert reach(shelf, np.array([0.0, 1.0, 0.0])) == pytest.approx(1.5)
    assert world.mapped == world.fixtures[:-1]


def test_objects_stand_on_side_tables_and_stay_on_them_as_they_move(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        GOOD.replace("count: 2", "count: 1")
        + "side_tables:\n"
        + "  - {name: shelf, centre: [1, 0], size: [0.4, 0.4], objects: {count: 2}}\n"
        + "  - {name: belt, centre: [1, 1], size: [0.4, 0.8], objects: {count: 1},\n"
        + "     motion: {along: [0.1, -0.5], period_s: 4, stop_s: 9}}\n"
    )
    world = load_scene(path, 0)
    assert [world.resting_on(obj) for obj in world.objects] == [
        "container",
        "shelf",
        "shelf",
        "belt",
    ]
    assert len({obj.name for obj in world.objects}) == 4
    still = [obj.pose.copy() for obj in world.objects[:3]]
    there = []
    for now in (0.0, 2.0, 4.0, 9.0, 20.0):
        world.move_to(now)
        assert world.resting_on(world.objects[3]) == "belt"
        there.append(world.objects[3].pose.translation[:2].copy())
    start, end, back, stopped, later = there
    np.testing.assert_allclose(end - start, [0.1, -0.5], atol=1e-9)
    np.testing.assert_allclose(back, start, atol=1e-9)
    np.testing.assert_allclose(stopped, start + np.array([0.05, -0.25]), atol=1e-9)
    np.testing.assert_array_equal(later, stopped)
    assert all(a.pose == b for a, b in zip(world.objects[:3], still, strict=True))


def test_objects_lie_on_any_box_and_below_another_one(tmp_path):
    path = tmp_path / "shelf.yaml"
    path.write_text(
        "fixtures:\n"
        "  - {name: shelf, centre: [1, 0, 0.74], size: [0.3, 0.8, 0.02], objects: {count: 3}}\n"
        "  - {name: shelf, centre: [1, 0, 0.82], size: [0.3, 0.8, 0.02], objects: {count: 3}}\n"
    )
    for seed in range(4):
        world = load_scene(path, seed)
        assert set(world.supports().values()) == {"shelf"}
        assert [one.pose.translation[2] > 0.82 for one in world.objects] == 3 * [False] + 3 * [True]
        boards = list(world.fixtures[1:])
        assert all(gap(one.placed(), boards) > -2e-4 for one in world.objects)


def test_what_the_hand_has_taken_no_longer_moves_by_itself(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        GOOD.replace("count: 2", "count: 0")
        + "side_tables:\n  - {name: belt, centre: [1, 1], size: [0.4, 0.8],\n"
        + "     objects: {count: 1, kinds: [ball], width_mm: [40, 50]},\n"
        + "     motion: {along: [0.0, 0.4], period_s: 4}}\n"
    )
    world = load_scene(path, 0)
    world.move_to(1.0)
    ball = world.objects[0]
    wTe = SE3(np.diag([1.0, -1.0, -1.0]), ball.pose.translation)
    outcome = world.close_fingers(Hand(load_robot("frankie").gripper, wTe), 0.08, 20.0)
    assert outcome.holding == ball.name
    taken = ball.pose.translation.copy()
    world.move_to(3.0)
    np.testing.assert_array_equal(ball.pose.translation, taken)


PAGE = (Path(__file__).parents[3] / "docs" / "scenes.md").read_text(encoding="utf-8")


def test_the_page_about_scenes_has_a_valid_example_and_all_keys_and_scenes(tmp_path):
    example = re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL)[0]
    path = tmp_path / "workshop.yaml"
    path.write_text(example)
    assert read_scene(path, (0.7, 0.5)).walkers[0].name == "Ada"
    assert len(load_scene(path, 0).objects) == 6
    models = (Scene, Container, Table, SideTable, Objects, Item, Motion, Fixture, Walker)
    keys = [key for model in models for key in model.model_fields]
    assert [key for key in keys if not re.search(rf"`{key}`|\b{key}: ", PAGE)] == []
    assert [name for name in scene_names() if f"`{name}`" not in PAGE] == []
