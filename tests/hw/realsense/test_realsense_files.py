"""Recordings play through the driver of the camera."""

import time

import numpy as np
import pytest
from emulated_camera import D435, needs_library, new_images, until

from hw import HardwareError, WallClock
from hw.clock import epoch
from hw.realsense import RealSenseCamera, RealSenseSettings

pytestmark = needs_library
IMAGES = 20


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A file as the vendor's recorder writes it; image k is a plane at 0.5 m + k mm."""
    import pyrealsense2 as rs

    path = tmp_path_factory.mktemp("recording") / "shelf.db3"
    told = rs.intrinsics()
    told.width, told.height, told.model = 640, 480, rs.distortion.brown_conrady
    told.fx, told.fy, told.ppx, told.ppy = 383.0, 383.0, 319.5, 239.5
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid, stream.fmt = rs.stream.depth, 0, 0, rs.format.z16
    stream.width, stream.height, stream.fps, stream.bpp = 640, 480, 30, 2
    stream.intrinsics = told
    device = rs.software_device()
    sensor = device.add_sensor("Stereo Module")
    profile = sensor.add_video_stream(stream)
    sensor.add_read_only_option(rs.option.depth_units, 0.001)
    recorder = rs.recorder(str(path), device)
    recorded = recorder.query_sensors()[0]
    recorded.open(recorded.get_stream_profiles()[0])
    queue = rs.frame_queue(IMAGES)
    recorded.start(queue)
    start = epoch() - 86400.0  # of yesterday
    for k in range(IMAGES):
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp = np.full((480, 640), 500 + k, np.uint16), 1280, 2
        frame.timestamp, frame.domain = (start + k / 30.0) * 1e3, rs.timestamp_domain.global_time
        frame.frame_number, frame.profile = k + 1, profile.as_video_stream_profile()
        frame.depth_units = 0.001
        sensor.on_video_frame(frame)
        time.sleep(1.0 / 30.0)
    recorded.stop()
    recorded.close()
    del recorded, recorder, sensor, device
    return path


def test_a_recording_plays_in_its_time_with_stamps_of_this_session(recording):
    clock = WallClock()
    camera = RealSenseCamera(D435, clock, RealSenseSettings(file=str(recording)))
    camera.connect()
    try:
        images = new_images(camera, 1.5)
        assert 25 <= len(images) <= 50
        shown = {round(float(image.depth[5, 5]) * 1e3) - 500 for image in images}
        assert shown <= set(range(IMAGES))
        assert len(shown) >= IMAGES - 4
        assert all(np.ptp(image.depth) == 0.0 for image in images)
        gaps = np.diff([image.stamp for image in images])
        assert np.median(gaps) == pytest.approx(1.0 / 30.0, abs=0.01)
        assert -0.05 < clock.now() - images[-1].stamp < 0.3
    finally:
        camera.close()


def test_the_end_of_a_recording_is_said_and_a_recovery_begins_again(recording):
    told = RealSenseSettings(file=str(recording), repeat=False)
    camera = RealSenseCamera(D435, WallClock(), told)
    camera.connect()
    try:
        until(camera.faults)
        until(lambda: "its recording is over" in camera.faults()[0].text)
        camera.recover()
        assert camera.faults() == ()
    finally:
        camera.close()


@pytest.mark.parametrize("name", ["none.db3", "broken.db3", "broken.bag"])
def test_a_file_that_cannot_be_played_is_refused(tmp_path, name):
    path = tmp_path / name
    if not name.startswith("none"):
        path.write_bytes(b"#ROSBAG V2.0\n1234567890")
    camera = RealSenseCamera(D435, WallClock(), RealSenseSettings(file=str(path)))
    with pytest.raises(HardwareError, match="cannot be played") as caught:
        camera.connect()
    assert "\n" not in str(caught.value)
    print(caught.value)
