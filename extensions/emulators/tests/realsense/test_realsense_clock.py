"""Stamps of cameras on the computer's clock; images in shared memory. No library is needed."""

import mmap
import os
import signal

import numpy as np
import pytest

from drivers.processes.timestamps import SensorClock
from drivers.realsense.image_buffer import ImageBuffer

PERIOD = 1.0 / 30.0


def test_a_calendar_stamp_tells_how_old_an_image_is():
    clock = SensorClock()
    assert clock.stamp(1e9 + 0.96, arrived=5.0, calendar=1e9 + 1.0) == pytest.approx(4.96)
    delayed = SensorClock(delay=0.01)
    assert delayed.stamp(1e9 + 0.96, arrived=5.0, calendar=1e9 + 1.0) == pytest.approx(4.95)


@pytest.mark.parametrize("own", [True, False])
def test_a_clock_of_its_own_is_tied_to_the_image_that_came_quickest(own):
    """Also a calendar that another computer has set wrongly."""
    rng = np.random.default_rng(1)
    clock, errors = SensorClock(), []
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


JUMPS = {
    "0.5 s back for a second (librealsense #11320)": lambda k: -0.5 if 150 <= k < 180 else 0.0,
    "0.1 s back for a second (#7922)": lambda k: -0.1 if 150 <= k < 180 else 0.0,
    "3 s back for a second": lambda k: -3.0 if 150 <= k < 180 else 0.0,
    "back again and again": lambda k: -0.2 if k > 90 and k % 30 < 10 else 0.0,
    "0.2 s into the future for a second (#13122)": lambda k: 0.2 if 150 <= k < 180 else 0.0,
    "stamped on arrival from then on, without metadata (#4505)": None,
}


@pytest.mark.parametrize("name", JUMPS)
@pytest.mark.parametrize("jitter", [0.0, 0.01])
def test_a_stamp_that_jumps_is_not_believed(name, jitter):
    rng, clock, stamps, captured = np.random.default_rng(0), SensorClock(), [], []
    for k in range(400):
        captured.append(100.0 + k * PERIOD)
        arrived = captured[-1] + 0.03 + rng.uniform(0.0, jitter)
        jump = JUMPS[name]
        on_arrival = arrived if k >= 150 else captured[-1]
        told = 1.7e9 + (captured[-1] + jump(k) if jump else on_arrival)
        stamps.append(clock.stamp(told, arrived, calendar=1.7e9 + arrived))
    assert np.abs(np.subtract(stamps, captured)).max() < 0.005 + jitter
    assert (np.diff(stamps) > 0.0).all()


@pytest.mark.parametrize("late", [0.1, 0.5])
def test_an_image_that_comes_late_keeps_its_stamp(late):
    """As on a computer that had other work: its stamp goes on, and its arrival does not."""
    clock = SensorClock()
    for k in range(100):
        captured = 100.0 + k * PERIOD
        arrived = captured + 0.035 + (late if 60 <= k < 65 else 0.0)
        stamp = clock.stamp(1.7e9 + captured, arrived, calendar=1.7e9 + arrived)
        assert stamp == pytest.approx(captured, abs=1e-6)


@pytest.mark.parametrize("step", [-0.3, 10.0])
def test_a_clock_that_was_set_for_good_is_taken_over_after_three_seconds(step):
    clock, captured = SensorClock(), 0.0
    for k in range(300):
        captured = 100.0 + k * PERIOD
        told = 1.7e9 + captured + (step if k >= 100 else 0.0)
        stamp = clock.stamp(told, captured + 0.035, calendar=1.7e9 + captured + 0.035)
        taken_over = k >= 99 + 3.0 / PERIOD
        assert stamp == pytest.approx(captured, abs=1e-6) or taken_over
    told = captured + step if step < 0.0 else captured  # what tells no age takes as long as before
    assert stamp == pytest.approx(told, abs=1e-6)


def image_buffer(size: int = 2000) -> ImageBuffer:
    return ImageBuffer(mmap.mmap(-1, ImageBuffer.size(size, 10)), 0, size, 10)


def test_an_image_buffer_gives_the_newest_image():
    one = image_buffer()
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
    """Nor that no image has come yet, which would stop the robot."""
    shared = image_buffer(100_000)  # 4 MB: long to write
    shared.put(0, 0.0, 0.0, np.ones((10, 100_000), np.float32), None)
    writer = os.fork()
    if writer == 0:
        for k in range(2, 1_000_000):
            shared.put(k, k, k, np.full((10, 100_000), k, np.float32), None)
    try:
        seen = 0
        while seen < 50:
            assert min(shared.newest_number() for _ in range(100)) > 0
            if (picture := shared.get(infrared=False)) is not None:
                seen += 1
                assert picture.depth.min() == picture.depth.max() == picture.number
    finally:
        os.kill(writer, signal.SIGKILL)
        os.waitpid(writer, 0)
