"""Static types of poses by their frame, with which mypy tells the map from odometry.

At run time each is a `pinocchio.SE3`, for which there are no types: what is made of parts, as
`SE3(R, p)`, fits everywhere; what is read from a state, a goal or the localiser does not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from typing import Self

    from config.arrays import Array

    class _Pose:
        """aTx: the pose of x in the frame a."""

        rotation: Array  # (3, 3)
        translation: Array  # (3,) [m]
        homogeneous: Array  # (4, 4)

        def __mul__(self, xTy: Any) -> Self: ...
        def actInv(self, other: Self | Array) -> Any: ...
        def act(self, point: Array) -> Array: ...
        def inverse(self) -> Any: ...
        def copy(self) -> Self: ...
        def isApprox(self, other: Self, precision: float = ...) -> bool: ...

    class MapPose(_Pose):
        """mTx: a pose on the map."""

    class OdometryPose(_Pose):
        """oTx: a pose in odometry."""

    class MapFromOdometry(MapPose):
        """mTo: odometry on the map."""

        def __mul__(self, oTx: OdometryPose) -> MapPose: ...  # type: ignore[override]
        def inverse(self) -> OdometryFromMap: ...  # noqa: D102

    class OdometryFromMap(OdometryPose):
        """oTm: the map in odometry."""

        def __mul__(self, mTx: MapPose) -> OdometryPose: ...  # type: ignore[override]
        def inverse(self) -> MapFromOdometry: ...  # noqa: D102
else:
    MapPose = OdometryPose = MapFromOdometry = OdometryFromMap = Any

Pose = TypeVar("Pose", bound="MapPose | OdometryPose")
"""A pose on the map, or in odometry."""
