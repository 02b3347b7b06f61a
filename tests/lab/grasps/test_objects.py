"""Objects of scenes, of training and of evaluation."""

import pickle

import numpy as np
import pytest

from hw.sim.objects import MAX_HEIGHT, OBJECT_CLASSES, make_object
from hw.sim.objects.making import MAX_LENGTH
from lab.grasps.objects import RANDOM_BODIES


def test_every_class_of_objects_stands_on_the_floor_is_not_large_and_depends_on_the_seed_alone():
    up, along = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    for seed, name in enumerate(4 * list(OBJECT_CLASSES)):
        ranges, kind = ((0.005, 0.07), (0.03, 0.5)), OBJECT_CLASSES[name]
        obj, same = (make_object("it", kind, *ranges, np.random.default_rng(seed)) for _ in "12")
        assert pickle.dumps(obj) == pickle.dumps(same)
        assert obj.reach(-up) == pytest.approx(0.0, abs=1e-9)
        assert 0.03 <= obj.mass <= 0.5
        if name in RANDOM_BODIES:
            assert 0.01 < obj.reach(up) < 0.2
        else:
            assert obj.reach(up) <= MAX_HEIGHT + 1e-9
            assert obj.reach(along) + obj.reach(-along) <= MAX_LENGTH + 1e-9
