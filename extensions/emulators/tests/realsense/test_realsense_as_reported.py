"""The driver on cameras that behave as people report them to behave."""

import time

import numpy as np
import pytest
from emulated_camera import D435, Counting, needs_library, plugged_in
from pinocchio import SE3
from waiting import until

from extensions.emulators.realsense import AS_REPORTED, Shot
from hw import DepthFrame, HardwareError
from hw.clock import stopwatch
from perception import FrameChecker

pytestmark = needs_library
DOWN = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 2.0]))

FAULTS = {
    "hangs-until-reset": "sends no images: it is reset",
    "hangs-until-replugged": "a reset does not help: unplug it and plug it in again",
    "freezes": "sends the same image again and again",
}
"""What a person is told meanwhile."""
SPELLS = {"stamps-back", "stamps-future", "freezes", "picture-frozen", "zero-depth"}
"""Ways that come for a second, after two; others are always there or begin after 1.5 s."""


class Noisy(Counting):
    """Its images have the noise of a camera."""

    def __init__(self) -> None:
        super().__init__()
        self._noise = np.random.default_rng(0).normal(0.0, 2e-3, (8, 480, 640)).astype(np.float32)

    def __call__(self) -> Shot:
        shot = super().__call__()
        depth = 0.5 + self._noise[len(self.stamps) % 8]
        depth[0] = shot.depth[0]
        return Shot(depth=depth, stamp=shot.stamp)


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize("way", sorted(AS_REPORTED.keys() - {"usb2"}))
def test_what_is_believed_is_true_and_what_is_wrong_is_said(monkeypatch, way):
    """Every image is stamped with its capture, or not believed; the camera is well in the end."""
    monkeypatch.setattr("extensions.emulators.realsense.emulator._BEGINS", 1.5)
    source, judge, said = Noisy(), FrameChecker(), set()
    judge.mistake(_frame(source().depth, 0.0))  # there is noise
    judge.mistake(_frame(source().depth, 0.0))
    with plugged_in(source, as_reported=(way,)) as (emulator, camera, clock):
        offset, last, believed = clock.now() - stopwatch(), None, []
        end = time.monotonic() + (3.3 if way in SPELLS else 2.8)
        while time.monotonic() < end or camera.faults() or len(believed) <= 40:
            assert time.monotonic() < end + 25.0, (camera.faults(), len(believed))
            said |= {fault.text for fault in camera.faults()}
            if (image := camera.latest()) is not last:
                last = image
                if not judge.mistake(_frame(image.depth, image.stamp)) and image.depth[0, 0] > 0.0:
                    believed.append(image)
            if any("unplug it" in fault.text for fault in camera.faults()):
                emulator.unplug()
                until(lambda: any("was unplugged" in fault.text for fault in camera.faults()))
                emulator.plug_in()
                until(lambda: camera.faults() == ())
            time.sleep(0.002)
        assert emulator.resets > 0 or not way.startswith("hangs")
    taken = [source.stamps[source.number(image.depth)] + offset for image in believed]
    errors = np.abs(np.subtract([image.stamp for image in believed], taken))
    # On a busy computer images come late, and of some nothing but the arrival is known.
    assert np.median(errors) < (0.04 if way == "metadata-lost" else 0.02)
    assert np.quantile(errors, 0.9) < 0.08
    stamps = [image.stamp for image in believed]
    assert stamps == sorted(set(stamps))
    if way in FAULTS:
        assert any(FAULTS[way] in text for text in said), said
    else:
        assert not said


def _frame(depth: np.ndarray, stamp: float) -> DepthFrame:
    return DepthFrame(depth=depth, intrinsics=D435.intrinsics, oTc=DOWN, stamp=stamp)


def test_usb_2_is_refused_and_old_firmware_told():
    refused = pytest.raises(HardwareError, match=r"at 30 Hz here: .* by USB 2")
    with refused, plugged_in(Noisy(), as_reported=("usb2",)):
        pass
    with plugged_in(Noisy(), as_reported=("old-firmware",)) as (_, camera, _):
        status = camera.report().status
        assert status.firmware < status.recommended
