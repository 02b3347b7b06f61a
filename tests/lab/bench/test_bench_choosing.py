"""The right object of a request, the judge's measurements, and the training of the seams."""

import numpy as np
import pytest

from hw import WorldError
from lab.bench.choosing import matching, take
from lab.bench.choosing_scenes import TrueObject, make_scene, seen_from_above, true_object
from lab.bench.seams import fit, mistakes, scene_seams

BASE = np.zeros(3)
OBJECTS = [
    TrueObject(name="can", colour="red", area=0.0030, width=0.050, middle=(0.70, 0.0)),
    TrueObject(name="box", colour="red", area=0.0029, width=0.030, middle=(0.80, 0.0)),
    TrueObject(name="ball", colour="blue", area=0.0010, width=0.035, middle=(0.71, 0.0)),
]


@pytest.mark.parametrize(
    ("words", "names"),
    [
        ({"choose": "largest"}, ["can", "box"]),  # nearly equal
        ({"choose": "smallest"}, ["ball"]),
        ({"choose": "nearest"}, ["can", "ball"]),
        ({"colour": "blue"}, ["ball"]),
        ({"colour": "green"}, []),
        ({"choose": "smallest", "colour": "red"}, ["box", "can"]),
        ({"max_width_mm": 32.0}, ["box"]),
        ({"min_width_mm": 40.0}, ["can"]),
    ],
)
def test_the_right_objects(words, names):
    assert matching(words, OBJECTS, BASE) == names


def test_an_unknown_world_is_an_error():
    with pytest.raises(WorldError, match="no world is called `water`"):
        take(0, world_name="water")


@pytest.mark.slow
def test_the_object_that_is_asked_for_is_taken():
    taking = take(0)
    assert taking.is_right
    assert taking.counted == taking.objects


def test_the_judge_measures_an_object_where_the_renderer_shows_it():
    world, _, _ = make_scene(0)
    frame, owner = seen_from_above(world, np.random.default_rng(0))
    for number, obj in enumerate(world.objects):
        rows, columns = np.nonzero(owner == number)
        ray = (columns.mean() - frame.intrinsics.cx, rows.mean() - frame.intrinsics.cy)
        depth = frame.wTc.translation[2] - obj.pose.translation[2]
        seen = frame.wTc.act(depth * np.array([*(np.array(ray) / frame.intrinsics.fx), 1.0]))
        assert np.linalg.norm(seen[:2] - true_object(obj).middle) < 0.02


@pytest.mark.slow
def test_the_training_finds_seams_between_objects_and_is_repeatable():
    seams = [one for seed in range(100_000, 100_024) for one in scene_seams(seed)]
    assert {one.right for one in seams} == {True, False}
    assert not any(one.right for one in seams if not one.many)
    model, again = fit(seams), fit(seams)
    for one, other in zip(model.layers, again.layers, strict=True):
        assert all((a == b).all() for a, b in zip(one, other, strict=True))
    pieces = {one.piece: one.many for one in seams}
    assert min(mistakes(model, seams).values()) < sum(pieces.values()) / 2
