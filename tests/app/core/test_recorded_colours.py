"""Recorded frames keep their colours, bit for bit; those of a camera without any have none."""

import numpy as np
from pinocchio import SE3

from app.core.files.frames import FrameStream, RecordedFrames
from hw import DepthFrame
from robots import load_robot

CAMERA = load_robot("frankie").camera.intrinsics


def test_colours_come_back_as_they_were(tmp_path):
    rng = np.random.default_rng(0)
    depth = rng.random((48, 64), dtype=np.float32)
    colour = rng.integers(0, 256, (48, 64, 3), dtype=np.uint8)
    frames = [
        DepthFrame(depth=depth, intrinsics=CAMERA, wTc=SE3.Identity(), stamp=s, paint=c)
        for s, c in ((0.0, lambda: colour), (0.1, None))
    ]
    path = tmp_path / "frames.arrows"
    path.write_bytes(FrameStream()(list(enumerate(frames, 1))))
    read = RecordedFrames(path, CAMERA)
    assert (read(1).colour == colour).all()
    second = read(2)
    assert second.colour is None
    assert (second.depth == depth).all()
