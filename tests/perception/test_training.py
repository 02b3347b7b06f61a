"""Labels from exact geometry, and a training loop that learns and repeats itself."""

from pathlib import Path

import numpy as np
import pytest
import torch
from pinocchio import SE3, exp3

from app.grasps.generate import generate, judge, view
from hw.sim import Box, D435Noise, Placed, SimObject, World
from perception.preprocess import METRES_PER_PIXEL
from perception.training import Progress, Sample, Samples, train

FLOOR = 0.456
PERFECT = D435Noise(disparity_noise=0.0, edge_loss=0.0, speckle=0.0, disparity_step=1e-4)


def world_with_a_box(yaw: float) -> World:
    """A box of 120 x 40 x 50 mm on a stand, and a wall of 6 x 300 x 50 mm beside it."""
    thing = SimObject(
        name="box",
        parts=(Placed(Box((0.06, 0.02, 0.025)), SE3.Identity()),),
        mass=0.2,
        pose=SE3(exp3(np.array([0.0, 0.0, yaw])), np.array([0.0, 0.0, FLOOR + 0.025])),
    )
    stand = Placed(Box((0.4, 0.4, 0.1)), SE3(np.eye(3), np.array([0.0, 0.0, FLOOR - 0.1])), "stand")
    wall = Placed(
        Box((0.003, 0.15, 0.025)), SE3(np.eye(3), np.array([0.15, 0.0, FLOOR + 0.025])), "wall"
    )
    return World([stand, wall], [thing])


def looked_at(yaw: float, camera_yaw: float) -> Sample:
    world = world_with_a_box(yaw)
    rotation = exp3(np.array([0.0, 0.0, camera_yaw])) @ np.diag([1.0, -1.0, -1.0])
    wTc = SE3(rotation, np.array([0.0, 0.0, FLOOR + 0.45]))
    rng = np.random.default_rng(0)
    return view(world, judge(world, FLOOR), wTc, FLOOR, rng, PERFECT)


@pytest.mark.parametrize(("yaw", "camera_yaw"), [(0.0, 0.0), (0.6, 0.0), (0.6, 0.9), (-0.8, 2.5)])
def test_labels_of_a_box_are_across_it_and_as_wide(yaw: float, camera_yaw: float) -> None:
    labels = looked_at(yaw, camera_yaw).labels
    good = labels.quality > 0.5
    assert good.sum() > 60
    # Seen from above with z downwards, the image's anticlockwise is the world's.
    turn = labels.angle[good] - (yaw + np.pi / 2 - camera_yaw)
    turn = (turn + np.pi / 2) % np.pi - np.pi / 2
    assert np.mean(np.abs(turn) < np.deg2rad(15)) > 0.95
    assert abs(np.median(turn)) < np.deg2rad(9)
    shown = 0.04 / METRES_PER_PIXEL * 0.45 / 0.40
    assert np.median(labels.width[good]) == pytest.approx(shown, rel=0.1)


def test_good_labels_lie_along_the_middle_of_the_box_only() -> None:
    labels = looked_at(0.0, 0.0).labels
    rows, columns = np.nonzero(labels.quality > 0.6)
    metres = METRES_PER_PIXEL * 3 * 0.40 / 0.45
    assert np.abs((rows - 49.5) * metres).max() < 0.0145
    assert np.abs((columns - 49.5) * metres).max() < 0.064


def test_a_wall_is_never_labelled_graspable() -> None:
    labels = looked_at(0.0, 0.0).labels
    assert labels.on_object.sum() == pytest.approx(0.12 * 0.04 / (0.004**2), rel=0.15)
    assert not labels.quality[~labels.on_object].any()
    assert not labels.quality[:, 78:].any()


def test_scenes_repeat_and_continue_one_another() -> None:
    a = generate(2, seed=5)
    b = generate(1, seed=5, first=1)
    assert np.array_equal(a[3].image, b[0].image)
    assert np.array_equal(a[3].labels.quality, b[0].labels.quality)
    assert not np.array_equal(a[0].image, a[3].image)


def test_training_learns() -> None:
    torch.set_num_threads(1)
    seen: list[float] = []

    def elapsed(progress: Progress) -> float:
        seen.append(progress.loss)
        return progress.step / 50

    samples = Samples([looked_at(yaw, 0.0) for yaw in (0.0, 0.7)])
    train(samples, seed=1, elapsed=elapsed, batch_size=2, learning_rate=8e-3)
    assert seen[-1] < 0.6 * seen[1]


def test_training_repeats_itself_also_from_a_file(tmp_path: Path) -> None:
    torch.set_num_threads(1)
    samples = Samples([looked_at(0.0, 0.0)])
    samples.save(tmp_path / "samples.npz")
    first, second = (
        train(known, seed=1, elapsed=lambda progress: progress.step / 4, batch_size=2)
        for known in (samples, Samples.load(tmp_path / "samples.npz"))
    )
    for a, b in zip(first.parameters(), second.parameters(), strict=True):
        assert torch.equal(a, b)


def test_mirrored_windows_mirror_their_labels() -> None:
    """Whatever the mirroring, closing stays across the box that the window shows."""
    samples = Samples([looked_at(0.6, 0.0)])
    rng = np.random.default_rng(0)
    angles = set()
    for _ in range(12):
        batch = samples.batch(192, np.zeros(1, dtype=np.int64), rng)
        target = batch.target[0].numpy()
        good = target[0] > 0.5
        if good.sum() < 60:
            continue
        rows, columns = np.nonzero(good)
        long_axis = np.linalg.eigh(np.cov(np.stack([columns, rows])))[1][:, 1]
        angle = 0.5 * np.arctan2(target[2][good].mean(), target[1][good].mean())
        closing = np.array([np.cos(angle), -np.sin(angle)])
        assert abs(closing @ long_axis) < 0.25
        angles.add(round(float(angle), 1))
    assert len(angles) > 1
