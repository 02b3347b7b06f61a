"""The whole task is in the picture, by projection."""

from math import tan

import numpy as np
import pytest
import sample_run as samples

from app.live import SceneView
from app.live.monitor.blueprint import FIELD, Eye, eye_for, task_points
from robots import Box, Geom


def projected(eye: Eye, points: np.ndarray) -> np.ndarray:
    """(N, 2) places in a picture of 1.5 by 1, whose middle is 0."""
    ahead = (eye.target - eye.position) / np.linalg.norm(eye.target - eye.position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    x, y, z = np.array([right, np.cross(right, ahead), ahead]) @ (points - eye.position).T
    assert (z > 0.0).all()
    return np.column_stack([x / z, y / z]) / (2.0 * tan(FIELD / 2.0))


def test_all_of_a_task_is_in_the_picture_and_fills_it() -> None:
    points = task_points(samples.SCENE)
    places = projected(eye_for(points), points)
    assert (np.abs(places) < [0.75, 0.5]).all()
    share = (places.max(axis=0) - places.min(axis=0)) / [1.5, 1.0]
    assert share.max() > 0.9, "not farther away than needed"


@pytest.mark.parametrize("far", [0.5, 40.0])
def test_any_room_fits(far: float) -> None:
    box = Geom(Box((0.3, 0.3, 0.3)), samples._at(far, -far, 0.3), "box")
    points = task_points(SceneView(fixtures=(box,)))
    assert (np.abs(projected(eye_for(points), points)) < [0.75, 0.5]).all()
