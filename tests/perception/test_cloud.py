"""The cloud of a depth image: parts of it are parts of the whole."""

import numpy as np
from pinocchio import SE3, exp3

from hw import DepthFrame
from robots import Intrinsics

CAMERA = Intrinsics(width=64, height=48, fx=60.0, fy=61.0, cx=31.5, cy=23.5)


def test_a_part_of_a_cloud_has_the_points_of_the_whole() -> None:
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.2, 6.0, (48, 64)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = np.nan
    oTc = SE3(exp3(np.array([0.3, -0.2, 1.0])), np.array([1.0, 2.0, 3.0]))
    frame = DepthFrame(depth=depth, intrinsics=CAMERA, oTc=oTc, stamp=0.0)
    whole = frame.cloud
    assert frame.cloud is whole
    assert whole.every(1) is whole.every(1)
    part = whole.part(slice(10, 30), slice(5, 50)).every(3, 1, 2)
    rows, columns = part.rows + 10, part.columns + 5
    assert whole.valid[rows, columns].all()
    assert len(rows) == np.isfinite(depth[11:30:3, 7:50:3])[depth[11:30:3, 7:50:3] < 5.0].sum()
    np.testing.assert_array_equal(part.points, whole.points(rows, columns))
    np.testing.assert_allclose(whole.project(part.points), np.stack([columns, rows], 1), atol=1e-9)
    np.testing.assert_allclose(whole.along_rays(part.points), part.points, atol=1e-12)
