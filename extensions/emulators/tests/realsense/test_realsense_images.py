"""Images of the driver: the right pixels, at the right places, with the right stamps."""

from dataclasses import replace

import numpy as np
import pytest
from emulated_camera import D435, Counting, needs_library, new_images, picture, plugged_in

from drivers.realsense import RealSenseCamera, RealSenseSettings
from extensions.emulators.realsense import Options, RealSenseEmulator, still
from hw import WallClock
from hw.clock import stopwatch
from robots import Intrinsics

pytestmark = needs_library


@pytest.mark.realtime
def test_depth_arrives_exactly_with_what_is_missing():
    with plugged_in() as (_, camera, clock):
        image = camera.latest()
        assert image.depth.dtype == np.float32
        np.testing.assert_allclose(image.depth, picture(), atol=1e-6)
        assert camera.faults() == ()
        assert 0.0 <= clock.now() - image.stamp < 0.3
        assert camera.latest_grey() is None


def test_the_infrared_image_belongs_to_the_depth_image():
    grey = np.arange(480 * 640, dtype=np.uint32).reshape(480, 640).astype(np.uint8)
    options = Options(infrared=True)
    with plugged_in(still(picture(), grey), options, infrared=True) as (_, camera, _):
        np.testing.assert_array_equal(camera.latest_grey().grey, grey)
        images = [(camera.latest(), camera.latest_grey()) for _ in range(20)]
        assert any(depth.stamp == image.stamp for depth, image in images)


LATE = {"delay": 0.05, "jitter": 0.04, "drop": 0.1}


@pytest.mark.realtime
@pytest.mark.parametrize("fault", [{}, pytest.param(LATE, marks=pytest.mark.slow)])
def test_a_stamp_is_that_of_the_capture_however_late_the_image_comes(fault):
    source = Counting()
    with plugged_in(source, Options(**fault)) as (_, camera, clock):
        offset = clock.now() - stopwatch()
        before = camera.report()
        images = new_images(camera, 30)
        stamps = [image.stamp for image in images]
        assert stamps == sorted(set(stamps))
        for image in images:
            taken = source.stamps[source.number(image.depth)] + offset
            assert image.stamp == pytest.approx(taken, abs=5e-3)
        report = camera.report()
        assert report.age > (0.05 if fault else 0.0)
        # Whatever was lost, by this fault or on a busy computer, is counted.
        counted = report.images + report.lost - before.images - before.lost
        numbers = [source.number(image.depth) for image in images]
        assert counted == pytest.approx(numbers[-1] - numbers[0], abs=2)
        if fault:
            assert report.lost > 0


def test_another_camera_is_brought_to_the_intrinsics_of_the_description():
    """A plane that is not parallel to the image, seen by two pinhole cameras at one place."""

    def tilted(one: Intrinsics) -> np.ndarray:
        x = (np.arange(one.width) - one.cx) / one.fx
        y = (np.arange(one.height) - one.cy) / one.fy
        return (0.8 / (1.0 + 0.2 * x[None, :] - 0.1 * y[:, None])).astype(np.float32)

    own = Intrinsics(width=640, height=480, fx=388.1, fy=387.6, cx=314.2, cy=244.9)
    small = Intrinsics(width=320, height=240, fx=191.5, fy=191.5, cx=159.5, cy=119.5)
    with RealSenseEmulator(still(tilted(own)), Options(intrinsics=own)) as emulator:
        told = RealSenseSettings(emulator=emulator.address)
        camera = RealSenseCamera(replace(D435, intrinsics=small), WallClock(), told)
        camera.connect()
        try:
            inner = (slice(20, -20), slice(20, -20))
            seen = camera.latest().depth
            np.testing.assert_allclose(seen[inner], tilted(small)[inner], atol=2.5e-3)
        finally:
            camera.close()
