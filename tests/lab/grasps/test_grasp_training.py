"""Training data: labels from exact geometry, the same for the same seed; recipes, a training."""

from pathlib import Path

import numpy as np
import pytest
from command_line import call
from pinocchio import SE3, exp3

from hw.sim import D435Noise, SimObject, World
from lab.grasps.scenes import FLOOR, ROBOT, View
from lab.grasps.seams import fit, mistakes, scene_seams
from lab.grasps.training_data import (
    label_world,
    render_sample,
    samples_of,
    shard_count,
    shard_path,
    write_shards,
)
from lab.grasps.training_samples import Sample, Shard
from perception import GraspDetector
from perception.grasps.network_input import ANGLE_BINS, GRID_SIZE, METRES_PER_PIXEL
from robots import Box, Geom

PERFECT = D435Noise(disparity_noise=0.0, edge_loss=0.0, speckle=0.0, disparity_step=1e-4)


def world_with_a_box(yaw: float) -> World:
    """A box of 120 x 40 x 50 mm on a stand, and a wall of 6 x 300 x 50 mm beside it."""

    def at(x: float, z: float) -> SE3:
        return SE3(np.eye(3), np.array([x, 0.0, FLOOR + z]))

    parts = (Geom(Box((0.06, 0.02, 0.025)), SE3.Identity()),)
    turn = SE3(exp3(np.array([0.0, 0.0, yaw])), np.zeros(3))
    box = SimObject(name="box 1", parts=parts, mass=0.2, pose=at(0.0, 0.025) * turn)
    stand = Geom(Box((0.4, 0.4, 0.1)), at(0.0, -0.1), "stand")
    return World([stand, Geom(Box((0.003, 0.15, 0.025)), at(0.15, 0.025), "wall")], [box])


def seen(yaw: float, camera_yaw: float, tilt: float = 0.0) -> Sample:
    world = world_with_a_box(yaw)
    turn = exp3(np.array([0.0, tilt, 0.0])) @ exp3(np.array([0.0, 0.0, camera_yaw]))
    place = np.array([0.45 * np.tan(tilt), 0.0, FLOOR + 0.45])
    view = View(wTc=SE3(turn @ np.diag([1.0, -1.0, -1.0]), place), noise=PERFECT)
    return render_sample(world, label_world(world), view, np.random.default_rng(0))


@pytest.mark.parametrize(("yaw", "camera_yaw", "tilt"), [(-0.8, 2.5, 0.0), (0.6, 0.9, 0.2)])
def test_labels_of_a_box_are_across_it_and_as_wide(yaw, camera_yaw, tilt):
    labels = seen(yaw, camera_yaw, tilt).labels
    good = labels.quality.max(axis=1) > 0.5
    assert good.sum() > 50
    best = labels.quality[good].argmax(axis=1)
    # Seen from above with z downwards, the image's anticlockwise is the world's.
    turn = best * np.pi / ANGLE_BINS - (yaw + np.pi / 2 - camera_yaw)
    turn = (turn + np.pi / 2) % np.pi - np.pi / 2
    assert np.mean(np.abs(turn) < np.deg2rad(15)) > 0.95
    shown = 0.04 / METRES_PER_PIXEL * 0.45 / 0.40
    assert np.median(labels.width[good, best]) == pytest.approx(shown, rel=0.1)


def test_a_wall_is_never_labelled() -> None:
    labels = seen(0.0, 0.0).labels
    rows, columns = np.divmod(labels.cell.astype(int), GRID_SIZE)
    cell = 3 * METRES_PER_PIXEL * 0.4 / 0.45
    assert len(rows) == pytest.approx(0.12 * 0.04 / cell**2, rel=0.15)
    assert columns.max() < 78


def test_samples_depend_only_on_seed_and_number() -> None:
    a, b, other = samples_of(5, 1), samples_of(5, 1), samples_of(5, 2)
    assert np.array_equal(a[2].image, b[2].image)
    assert np.array_equal(a[2].labels.quality, b[2].labels.quality)
    assert not np.array_equal(a[0].image, other[0].image)


@pytest.mark.slow
def test_shards_do_not_depend_on_the_number_of_processes(tmp_path: Path) -> None:
    (alone,) = write_shards(tmp_path / "a", 1, 0, 1)
    together, _ = sorted(write_shards(tmp_path / "b", 2, 0, 2))  # they come as they are done
    a, b = Shard.load(alone), Shard.load(together)
    assert np.array_equal(a.image, b.image)
    assert np.array_equal(a.quality, b.quality)
    assert list(write_shards(tmp_path / "a", 1, 0, 1)) == []
    assert shard_count(257) == 2
    assert alone == shard_path(tmp_path / "a", 0, 0)


@pytest.mark.slow
def test_training_from_a_recipe_writes_weights(tmp_path: Path) -> None:
    recipe = tmp_path / "tiny.yaml"
    recipe.write_text(
        "data: {images: 1, validation_images: 1}\nlearning: {rounds: 2, steps: 2, batch: 2}\n"
    )
    code, _, err = call("grasp", "train", recipe, "--folder", tmp_path / "t", "--workers", 2)
    assert code == 0, err
    GraspDetector.shipped(ROBOT.gripper, tmp_path / "t" / "ggcnn.safetensors")


def test_the_training_finds_seams_between_objects_and_is_repeatable() -> None:
    seams = [one for seed in range(100_000, 100_024) for one in scene_seams(seed)]
    assert {one.right for one in seams} == {True, False}
    assert not any(one.right for one in seams if not one.many)
    model, again = fit(seams), fit(seams)
    for one, other in zip(model.layers, again.layers, strict=True):
        assert all((a == b).all() for a, b in zip(one, other, strict=True))
    pieces = {one.piece: one.many for one in seams}
    assert min(mistakes(model, seams).values()) < sum(pieces.values()) / 2
