"""The whole task is in the picture, by projection, and the viewer projects as this says."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import sample_run as samples
from recordings import record
from rerun.chunk import RrdReader
from test_headless_viewer import wait_for

from app.live import SceneView
from app.live.monitor.framing import Eye, eye_for, robot_points, task_points
from app.live.viewer.headless import has_vulkan, headless_viewer
from robots import Box, Geom


def eyes_of(path: Path) -> list[Eye]:
    """The eyes of a recording's layouts, of which the newest is the one that is used."""
    reader, eyes = RrdReader(path), []
    for layout in reader.blueprints():
        for chunk in reader.stream(store=layout).to_chunks():
            batch = chunk.to_record_batch()
            found = {
                name.partition(":")[2]: np.array(batch.column(name)[0].as_py()[0])
                for name in batch.schema.names
                if name.startswith("EyeControls3D")
            }
            if found:
                eyes.append(Eye(position=found["position"], target=found["look_target"]))
    return eyes


def inside(eye: Eye, points: np.ndarray, width: float, height: float) -> bool:
    pixels = eye.project(points, width, height)
    return bool(((pixels > 0.0) & (pixels < [width, height])).all())


def test_all_of_a_task_is_in_the_picture_and_fills_it() -> None:
    points = task_points(samples.SCENE)
    eye = eye_for(points)
    assert inside(eye, points, 1.5, 1.0)
    pixels = eye.project(points, 1.5, 1.0)
    share = (pixels.max(axis=0) - pixels.min(axis=0)) / [1.5, 1.0]
    assert share.max() > 0.9, "not farther away than needed"


@pytest.mark.parametrize("far", [0.5, 3.0, 40.0])
def test_any_room_fits(far: float) -> None:
    box = Geom(Box((0.3, 0.3, 0.3)), samples._at(far, -far, 0.3), "box")
    points = task_points(SceneView(fixtures=(box,)))
    assert eye_for(points).sees(points)


def test_a_robot_that_leaves_the_picture_widens_it(tmp_path: Path) -> None:
    run = [
        samples.snapshot(tick)
        if tick < 20
        else samples.replace(
            samples.snapshot(tick),
            state=samples.replace(samples.snapshot(tick).state, wTb=samples._at(-9.0, -4.0, 0.0)),
        )
        for tick in range(40)
    ]
    (still,) = eyes_of(record(tmp_path / "still.rrd", run[:20]))
    gone = robot_points(-9.0, -4.0)
    assert not inside(still, gone, 1.6, 1.0)
    seen = np.concatenate([gone, task_points(samples.SCENE)])
    first, then = sorted(
        eyes_of(record(tmp_path / "gone.rrd", run)),
        key=lambda eye: float(np.linalg.norm(eye.position - eye.target)),
    )
    assert not inside(first, seen, 1.6, 1.0)
    assert inside(then, seen, 1.6, 1.0)


@pytest.mark.slow
@pytest.mark.skipif(
    not has_vulkan(), reason="the viewer needs Vulkan: apt-get install mesa-vulkan-drivers"
)
def test_the_viewer_shows_a_point_where_the_projection_says(tmp_path: Path) -> None:
    centre = np.array([1.0, 0.8, 0.9])
    pink = Geom(Box((0.06, 0.06, 0.06)), samples._at(*centre), "pink", (255, 0, 255))
    scene = samples.replace(samples.SCENE, fixtures=(*samples.SCENE.fixtures, pink))
    path = record(tmp_path / "x.rrd", list(samples.run(60)), scene=scene)
    (eye,) = eyes_of(path)
    with headless_viewer(size="1280x720") as viewer:
        viewer.client.open(str(path))
        views = wait_for(lambda: viewer.client.get_state().views)
        viewer.client.set_time("t", duration=1.0, play_state="paused")
        (view,) = (v.view_id for v in views if v.name == "scene")

        def marked():
            png = np.frombuffer(viewer.client.take_screenshot(view), np.uint8)
            image = cv2.imdecode(png, cv2.IMREAD_COLOR).astype(int)
            blue, green, red = image.transpose(2, 0, 1)
            spots = np.argwhere((red - green > 60) & (blue - green > 60) & (red > 90))
            return (image.shape, spots) if len(spots) > 10 else None

        (height, width, _), spots = wait_for(marked)
    found = np.median(spots[:, ::-1], axis=0)
    expected = eye.project(centre[None], width, height)[0]
    assert np.abs(found - expected).max() < 12.0, (found, expected)
