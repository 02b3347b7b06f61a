"""Stamps of cameras on the computer's clock; images in shared memory. No library is needed."""

import mmap
import os
import time

import numpy as np
import pytest

from hw.realsense.album import Album
from hw.realsense.stamps import CameraClock

PERIOD = 1.0 / 30.0


def test_a_calendar_stamp_tells_how_old_an_image_is():
    clock = CameraClock()
    assert clock.stamp(1e9 + 0.96, arrived=5.0, calendar=1e9 + 1.0) == pytest.approx(4.96)
    delayed = CameraClock(delay=0.01)
    assert delayed.stamp(1e9 + 0.96, arrived=5.0, calendar=1e9 + 1.0) == pytest.approx(4.95)


def test_an_image_never_comes_from_the_future():
    clock = CameraClock()
    assert clock.stamp(1e9 + 0.002, arrived=5.0, calendar=1e9) == 5.0


@pytest.mark.parametrize("own", [True, False])
def test_a_clock_of_its_own_is_tied_to_the_image_that_came_quickest(own):
    """Also a calendar that another computer has set wrongly."""
    rng = np.random.default_rng(1)
    clock, errors = CameraClock(), []
    for k in range(300):
        captured = 10.0 + k * PERIOD
        arrived = captured + 0.004 + rng.exponential(0.01)
        told = captured - 3.0
        calendar = None if own else arrived + 500.0
        errors.append(clock.stamp(told, arrived, calendar) - captured)
    late = np.array(errors[60:])
    assert late.min() > 0.0
    assert late.max() < 0.006
    assert np.std(late) < 1e-3


def test_a_recording_that_begins_again_is_tied_anew():
    clock = CameraClock()
    for k in range(30):
        assert clock.stamp(k * PERIOD, 100.0 + k * PERIOD, None) == pytest.approx(100 + k * PERIOD)
    assert clock.stamp(0.0, 102.0, None) == pytest.approx(102.0)


def album(size: int = 2000) -> Album:
    return Album(mmap.mmap(-1, Album.size(size, 10)), 0, size, 10)


def test_an_album_gives_the_newest_image():
    one = album()
    assert one.get(infrared=True) is None
    assert one.arrival() is None
    for k in range(1, 8):
        depth, grey = np.full((10, 2000), k, np.float32), np.full((10, 2000), k, np.uint8)
        one.put(k, 0.5 * k, 1.0 * k, depth, grey)
        picture = one.get(infrared=True)
        told = (picture.number, picture.frames, picture.stamp, picture.arrived)
        assert told == (k, k, 0.5 * k, k)
        assert (picture.depth == k).all()
        assert (picture.infrared == k).all()


def test_a_reader_never_sees_two_images_mixed():
    shared = album(100_000)  # 4 MB: long to write
    end = time.monotonic() + 1.0
    writer = os.fork()
    if writer == 0:
        k = 0
        while time.monotonic() < end:
            k += 1
            shared.put(k, k, k, np.full((10, 100_000), k, np.float32), None)
        os._exit(0)
    seen = 0
    while time.monotonic() < end:
        if (picture := shared.get(infrared=False)) is not None:
            seen += 1
            assert picture.depth.min() == picture.depth.max() == picture.number
    os.waitpid(writer, 0)
    assert seen > 20
