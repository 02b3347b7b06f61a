"""Shards keep samples, windows keep labels where they belong, and training learns and resumes."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from lab.grasps.ggcnn_training import RoundReport, TrainingSettings, train
from lab.grasps.torch_networks import GGCNN
from lab.grasps.training_samples import WINDOW, Labels, Sample, SampleStream, Shard
from perception.grasps.network_input import ANGLE_BINS, INPUT_SIZE, OUTPUT_STRIDE

SETTINGS = TrainingSettings(seed=1, rounds=2, steps=3, batch=2, in_memory=1)


def bar(u: int, v: int, angle: float, length: int = 70, width: int = 16) -> Sample:
    """A bar on a table: 50 mm high, its long side at an angle against v; good to close across."""
    rows, columns = np.mgrid[0:INPUT_SIZE, 0:INPUT_SIZE]
    along = (columns - u) * np.cos(angle) - (rows - v) * np.sin(angle)
    across = (columns - u) * np.sin(angle) + (rows - v) * np.cos(angle)
    on = (np.abs(along) < length / 2) & (np.abs(across) < width / 2)
    image = np.where(on, -0.05, 0.0).astype(np.float32)
    cell = np.flatnonzero((on & (np.abs(across) < 4))[1::OUTPUT_STRIDE, 1::OUTPUT_STRIDE])
    best = (angle + np.pi / 2) * ANGLE_BINS / np.pi
    turn = (np.arange(ANGLE_BINS) - best + ANGLE_BINS / 2) % ANGLE_BINS - ANGLE_BINS / 2
    quality = np.repeat(np.exp(-0.5 * turn**2)[None], len(cell), axis=0)
    widths = np.full(quality.shape, width, dtype=np.float32)
    labels = Labels(cell=cell.astype(np.int16), quality=quality.astype(np.float32), width=widths)
    return Sample(image=image, labels=labels)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few validation windows, and single precision, which many processors compute faster."""
    monkeypatch.setattr("lab.grasps.ggcnn_training._VALIDATION_BATCHES", 2)
    monkeypatch.setattr(torch, "autocast", lambda *_, **__: nullcontext())


@pytest.fixture
def shards(tmp_path: Path) -> list[Path]:
    rng = np.random.default_rng(0)
    paths = []
    for number in range(3):
        samples = [bar(*rng.integers(100, 200, 2), rng.uniform(0, np.pi)) for _ in range(4)]
        paths.append(tmp_path / f"{number}.npz")
        Shard.of(samples).save(paths[-1])
    return paths


def test_a_shard_keeps_what_was_put_in(tmp_path: Path) -> None:
    samples = [bar(150, 120, 0.3), bar(80, 200, 1.2, width=30)]
    Shard.of(samples).save(tmp_path / "s.npz")
    loaded = Shard.load(tmp_path / "s.npz")
    assert len(loaded) == 2
    for index, sample in enumerate(samples):
        assert loaded.image[index] * 1e-4 == pytest.approx(sample.image, abs=1e-4)
        quality, width, on_object = loaded.dense(index)
        cells = sample.labels.cell
        flat = quality.reshape(-1, ANGLE_BINS)
        assert flat[cells] == pytest.approx(sample.labels.quality, abs=0.003)
        assert width.reshape(-1, ANGLE_BINS)[cells] == pytest.approx(sample.labels.width, abs=0.3)
        assert on_object.sum() == len(cells)
        assert flat.sum() == pytest.approx(flat[cells].sum())
    assert not list(tmp_path.glob("*.part"))


def test_however_a_window_is_turned_closing_stays_across_the_bar(tmp_path: Path) -> None:
    Shard.of([bar(150, 150, 0.5)]).save(tmp_path / "s.npz")
    stream = SampleStream([tmp_path / "s.npz"], seed=0)
    seen = set()
    for _ in range(24):
        batch = stream.draw(1)
        assert batch.image.shape == (1, 1, WINDOW, WINDOW)
        rows, columns = np.nonzero(batch.quality[0].max(axis=0) > 0.5)
        on_bar = batch.image[0, 0][OUTPUT_STRIDE * rows + 1, OUTPUT_STRIDE * columns + 1]
        assert np.mean(on_bar < -0.03) > 0.9  # labels lie on the bar, also after zooming
        if len(rows) < 12:
            continue
        long_axis = np.linalg.eigh(np.cov(np.stack([columns, rows])))[1][:, 1]
        best = batch.quality[0][:, rows, columns].mean(axis=1).argmax()
        angle = best * np.pi / ANGLE_BINS
        assert abs(np.array([np.cos(angle), -np.sin(angle)]) @ long_axis) < 0.35
        seen.add(int(best))
    assert len(seen) >= 4  # two ways round, mirrored or not


def test_training_learns(shards: list[Path]) -> None:
    torch.set_num_threads(1)
    torch.manual_seed(0)
    reports: list[RoundReport] = []
    recipe = TrainingSettings(seed=1, rounds=4, steps=12, batch=2, learning_rate=8e-3, in_memory=3)
    train(GGCNN(), shards[:2], shards[2:], recipe, report=reports.append)
    assert len(reports) == 4
    assert reports[-1].loss < 0.8 * reports[0].loss
    assert reports[-1].best == min(each.validation for each in reports)


def test_an_interrupted_training_ends_with_the_same_weights(shards, tmp_path):
    torch.set_num_threads(1)

    class StoppedError(Exception):
        pass

    def stop(report: RoundReport) -> None:
        raise StoppedError

    def trained(settings=SETTINGS, **options) -> GGCNN:
        torch.manual_seed(5)
        return train(GGCNN(), shards[:2], shards[2:], settings, **options).network

    whole, checkpoint = trained(), tmp_path / "c"
    with pytest.raises(StoppedError):
        trained(checkpoint=checkpoint, report=stop)
    reports: list[RoundReport] = []
    resumed = trained(checkpoint=checkpoint, report=reports.append)
    assert [each.round for each in reports] == [2]
    with pytest.raises(ValueError, match="another recipe"):
        trained(replace(SETTINGS, seed=2), checkpoint=checkpoint)
    for a, b in zip(whole.state_dict().values(), resumed.state_dict().values(), strict=True):
        assert torch.equal(a, b)
