"""Who is meant, by things as they truly lie."""

from __future__ import annotations

import numpy as np
import pytest

from hw import WorldError
from lab.bench.choosing import meant, take
from lab.bench.choosing_scenes import TrueThing

BASE = np.zeros(3)
THINGS = [
    TrueThing(name="can", colour="red", area=0.0030, width=0.050, middle=(0.70, 0.0)),
    TrueThing(name="box", colour="red", area=0.0029, width=0.030, middle=(0.80, 0.0)),
    TrueThing(name="ball", colour="blue", area=0.0010, width=0.035, middle=(0.71, 0.0)),
]


@pytest.mark.parametrize(
    ("words", "names"),
    [
        ({"choose": "largest"}, ["can", "box"]),  # as good as equal
        ({"choose": "smallest"}, ["ball"]),
        ({"choose": "nearest"}, ["can", "ball"]),
        ({"colour": "blue"}, ["ball"]),
        ({"colour": "green"}, []),
        ({"choose": "smallest", "colour": "red"}, ["box", "can"]),
        ({"max_width_mm": 32.0}, ["box"]),
        ({"min_width_mm": 40.0}, ["can"]),
    ],
)
def test_those_that_may_be_taken(words, names):
    assert meant(words, THINGS, BASE) == names


def test_a_world_that_there_is_not_is_said_so():
    with pytest.raises(WorldError, match="no world is called `water`"):
        take(0, world_name="water")
