"""The moments of the pictures in docs: robot, goal and object are in each, by projection."""

from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader, StoreEntry

from app.core import RECORDING
from app.live.monitor.framing import Eye
from app.review.screenshots import moments

VIEWS = {"1600x900": (779, 471), "1280x720": (623, 362)}
"""Size of the 3-D view in each window, as measured in the viewer [px]."""


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def scenes(tmp_path_factory) -> dict[str, tuple[Path, float]]:
    return moments(tmp_path_factory.mktemp("runs"))


def eyes_of(recording: Path) -> list[Eye]:
    """That of each layout: the eye may step back when the robot comes near the picture's edge."""
    reader = RrdReader(recording)
    return [eye_of(reader, layout) for layout in reader.blueprints()]


def eye_of(reader: RrdReader, layout: StoreEntry) -> Eye:
    for chunk in reader.stream(store=layout).to_chunks():
        batch = chunk.to_record_batch()
        found = {
            name.partition(":")[2]: np.array(batch.column(name)[0].as_py()[0])
            for name in batch.schema.names
            if name.startswith("EyeControls3D")
        }
        if found:
            return Eye(position=found["position"], target=found["look_target"])
    raise AssertionError("the layout has no eye")


def placed_at(recording: Path, moment: float) -> dict[str, np.ndarray]:
    """Where every frame was at a moment, by name, (3,) in the world."""
    newest: dict[str, tuple[float, np.ndarray]] = {}
    for chunk in RrdReader(recording).stream().filter(content="/world/poses").to_chunks():
        batch = chunk.to_record_batch()
        names = batch.schema.names
        child = next(name for name in names if name.endswith("child_frame"))
        where = next(name for name in names if name.endswith("translation"))
        times = batch.column("t").cast("int64").to_numpy() / 1e9
        rows = zip(
            times, batch.column(child).to_pylist(), batch.column(where).to_pylist(), strict=True
        )
        for t, (name,), (point,) in rows:
            if t <= moment + 1e-6 and t >= newest.get(name, (-1.0, None))[0]:
                newest[name] = (t, np.array(point))
    return {name: point for name, (_, point) in newest.items()}


@pytest.mark.parametrize("size", VIEWS)
@pytest.mark.parametrize("name", ["navigate", "grasp", "place", "fault", "end"])
def test_robot_goal_and_object_are_in_the_picture(scenes, name: str, size: str) -> None:
    run, moment = scenes[name]
    eyes, frames = eyes_of(run / RECORDING), placed_at(run / RECORDING, moment)
    robot = [point for frame, point in frames.items() if frame.startswith("world/robot/")]
    objects = [point for frame, point in frames.items() if frame.startswith("world/objects/")]
    assert len(robot) == 12
    assert len(objects) == 1
    base = frames["world/robot/base"]
    corners = [
        base + np.array([x, y, z]) for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (0.0, 0.4)
    ]
    width, height = VIEWS[size]
    seen = np.array([*robot, *corners, *objects, frames["world/goal"]])
    assert eyes
    for eye in eyes:
        pixels = eye.project(seen, width, height)
        assert ((pixels > 0) & (pixels < [width, height])).all(), pixels
        spread = pixels[: len(robot)].max(axis=0) - pixels[: len(robot)].min(axis=0)
        assert spread.max() > 0.05 * width, "and it is not a dot"


def test_the_moments_are_what_they_are_called(scenes) -> None:
    times = [scenes[name][1] for name in ("navigate", "grasp", "place", "end")]
    assert times == sorted(times)
    assert scenes["fault"][0] != scenes["end"][0]
