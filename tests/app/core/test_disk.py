"""The growing files of a run: whole at every moment, and what goes wrong with them is told once."""

import os
import resource
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from app.core.files.disk import Disk
from config import UserError


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file of this process grows beyond this: as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def row(number: int) -> bytes:
    return np.array([number, number + 0.5]).tobytes()


def test_an_array_can_be_loaded_while_it_grows_and_holds_every_row_in_order(tmp_path):
    disk = Disk(tmp_path, lossless=True)
    array = disk.array("rows.npy", (np.float64, (2,)))
    seen = []
    for number in range(50_000):
        array.add(row(number))
        if number % 5_000 == 0:
            loaded = np.load(tmp_path / "rows.npy")
            assert (loaded[:, 0] == np.arange(len(loaded))).all()
            seen.append(len(loaded))
    assert disk.close() == []
    assert seen[-1] > 0, "nothing was written before the end"
    expected = np.stack([np.arange(50_000), np.arange(50_000) + 0.5], axis=1)
    assert (np.load(tmp_path / "rows.npy") == expected).all()


def test_a_full_disk_ends_one_file_and_spares_the_others(tmp_path):
    disk = Disk(tmp_path, lossless=True)
    large, small = disk.array("large.npy", (np.float64, (2,))), disk.file("small.txt")
    with largest_file(10_000):
        for number in range(5_000):
            large.add(row(number))
        small.add(b"still here")
        wrong = disk.close()
    assert wrong == ["large.npy ends early (File too large)"]
    assert (tmp_path / "small.txt").read_bytes() == b"still here"
    kept = np.load(tmp_path / "large.npy")
    assert (kept[:, 0] == np.arange(len(kept))).all()


def test_a_folder_that_is_removed_is_told(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    disk = Disk(folder, lossless=True)
    disk.file("log.txt").add(b"line")
    shutil.rmtree(folder)
    assert disk.close() == ["log.txt was removed while it was written"]


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    disk = Disk(tmp_path / "nowhere", lossless=True)
    with pytest.raises(UserError, match="cannot be written"):
        disk.file("log.txt")
    disk.close()


def test_a_run_in_real_time_never_waits_for_a_disk_that_hangs(tmp_path):
    """A pipe that nobody reads takes no more than 64 kB; then writing hangs."""
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    disk = Disk(tmp_path, lossless=False, capacity=100)
    pipe = disk.file("pipe")
    loop = threading.Thread(target=lambda: [pipe.add(bytes(10_000)) for _ in range(1000)])
    loop.start()
    loop.join(10.0)
    assert not loop.is_alive()
    assert disk.close(0.1) == ["the disk did not take the rest of the run within 0 s"]
    os.close(reader)
    assert "pipe ends early (Broken pipe)" in disk.close()  # it goes on, and ends
