"""The surfaces of the map: signed distances of many points to many convex shapes, with normals."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from config.arrays import Array, Indices, Mask
from config.planar import in_space
from perception.registration.sensors import Cloud
from robots import Box, Cylinder, Geom, Hull, Plane, from_rounded_boxes, rounded_box

_CORE = 0.8
"""Share of a shape that a ray must go through: a pose is never exact."""
_AWAY = 0.2
"""A ray that ends so far behind a shape, or before it, does not see it [m]."""
_TOUCH = 0.01
"""Pieces with a smaller gap touch each other [m]."""


class Surfaces:
    """The shapes of a map, grouped by the piece of furniture that they belong to; immutable."""

    def __init__(
        self, pieces: Mapping[str, Sequence[Geom]], fixed: Collection[str] = frozenset()
    ) -> None:
        """Note the shapes; floors (`Plane`) are left out.

        Args:
            pieces: shapes of each piece by its name, posed in the map.
            fixed: names of pieces that cannot have moved, such as walls.
        """
        self.names = tuple(pieces)
        self.fixed: Mask = np.array([name in fixed for name in self.names], dtype=bool)
        """(P,) of pieces."""
        owned = [
            (number, geom)
            for number, geoms in enumerate(pieces.values())
            for geom in geoms
            if not isinstance(geom.shape, Plane)
        ]
        shapes = [geom.shape for _, geom in owned]
        rounded = [rounded_box(shape) for shape in shapes]
        self.piece: Indices = np.array([number for number, _ in owned], dtype=np.int64)
        """(B,) the piece of each shape."""
        self._rotations = np.array([g.pose.rotation for _, g in owned]).reshape(-1, 3, 3)
        self._origins = np.array([g.pose.translation for _, g in owned]).reshape(-1, 3)
        self._radius = np.array([radius for _, radius in rounded])
        self._half = np.array([half for half, _ in rounded]).reshape(-1, 3)
        self._is_box: Mask = np.array([isinstance(shape, Box) for shape in shapes], dtype=bool)
        self._is_cylinder: Mask = np.array([isinstance(s, Cylinder) for s in shapes], dtype=bool)
        self._hulls = {
            number: _faces(shape) for number, shape in enumerate(shapes) if isinstance(shape, Hull)
        }
        counts = np.maximum(np.bincount(self.piece, minlength=len(self.names)), 1)
        sums = np.zeros((len(self.names), 2))
        np.add.at(sums, self.piece, self._origins[:, :2])
        self.centres: Array = sums / counts[:, None]
        """(P, 2) the point about which each piece is said to turn, in the map [m]."""

        self.stacks: Indices = self._stacks()
        """(P,) pieces of one number touch each other: who moves one moves all."""

    def _stacks(self) -> Indices:
        """(P,) the first piece that each touches, over others or directly; walls do not count."""
        if not self.names:
            return np.zeros(0, dtype=np.int64)
        around = np.abs(self._rotations) @ (self._half + self._radius[:, None])[:, :, None]
        low, high = self._origins - around[:, :, 0] - _TOUCH, self._origins + around[:, :, 0]
        near = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
        near &= ~self.fixed[self.piece] & ~self.fixed[self.piece][:, None]
        joined = np.eye(len(self.names), dtype=bool)
        np.logical_or.at(joined, (self.piece[:, None], self.piece), near)
        while (further := joined @ joined).sum() > joined.sum():
            joined = further
        first: Indices = joined.argmax(axis=1)
        return first

    def __len__(self) -> int:
        return len(self.piece)

    def nearest(self, points: Array, count: int) -> tuple[Indices, Array]:
        """The shapes (N, C) whose boxes are nearest to points (N, 3), in no order.

        C is `count`, or the number of shapes. Also the distance (N,) of the nearest box [m],
        infinite if there are no shapes.
        """
        if not len(self):
            return np.zeros((len(points), 1), dtype=np.int64), np.full(len(points), np.inf)
        local = np.matmul(points - self._origins[:, None], self._rotations)
        away = np.maximum(np.abs(local, out=local) - self._half[:, None], 0.0)
        squares = np.einsum("bnj,bnj->nb", away, away)
        if count < len(self):
            found = np.argpartition(squares, count - 1, axis=1)[:, :count]
        else:
            found = np.broadcast_to(np.arange(len(self)), squares.shape)
        return found, np.sqrt(squares[np.arange(len(points)), found.T].min(axis=0))

    def missed(self, mTb: Array, cloud: Cloud) -> Indices:
        """(2, P) how many rays of a cloud, from a pose (3,), miss each piece in their way.

        They end far behind it, as there is nothing where the map has it, or before they reach it.
        """
        base = in_space(mTb)
        eye, ends = base.act(cloud.eye), cloud.ends @ base.rotation.T + base.translation
        start, local = (
            np.matmul(points - self._origins[:, None], self._rotations) for points in (eye, ends)
        )
        half = (_CORE * (self._half + self._radius[:, None]))[:, None]
        enter, leave = _slabs(start, local, half)
        length = np.linalg.norm(ends - eye, axis=1)
        meets = (enter < leave) & (enter > 0.0)
        ways = (1.0 - leave) * length > _AWAY, (enter - 1.0) * length > _AWAY
        counts = np.zeros((2, len(self.names)), dtype=np.int64)
        for row, way in zip(counts, ways, strict=True):
            np.add.at(row, self.piece, (meets & way).sum(axis=1))
        return counts

    def distances(self, points: Array, shapes: Indices, eyes: Array) -> tuple[Array, Array, Mask]:
        """Signed distances (N,) of points (N, 3) to one shape each (N,) [m], and normals (N, 3).

        What is measured is the side in front. So a point inside a box or behind it is measured from
        the faces that can be seen: a thin leg or wall must not be matched from behind. Of other
        shapes (N,) is true where that side was met.

        Exact for boxes, balls, capsules and cylinders; beside an edge of a hull it is the distance
        to the plane of a face.

        Args:
            points: in the map [m].
            shapes: indices.
            eyes: (N, 3) from where each point was measured, in the map [m].
        """
        R, origins, half = (
            table.take(shapes, axis=0) for table in (self._rotations, self._origins, self._half)
        )
        local = np.einsum("nij,ni->nj", R, points - origins)
        eye = np.einsum("nij,ni->nj", R, eyes - origins)
        behind = _pierced(eye, local, half)
        (boxes,) = np.nonzero(behind & self._is_box[shapes])
        in_front = _from_visible_faces(local[boxes], eye[boxes], half[boxes])
        (round_,) = np.nonzero(self._is_cylinder[shapes])
        # In the plane of axis and point, a cylinder is a rectangle.
        q = local.copy()
        radial = np.hypot(local[round_, 0], local[round_, 1])
        outwards = local[round_, :2] / np.maximum(radial, 1e-12)[:, None]
        q[round_, 0], q[round_, 1], half[round_, 1] = radial, 0.0, np.inf
        d, n = from_rounded_boxes(q, half, self._radius[shapes])
        n[round_, :2] = n[round_, :1] * outwards
        for number, (normals, offsets) in self._hulls.items():
            (some,) = np.nonzero(shapes == number)
            beyond = local[some] @ normals.T - offsets
            face = beyond.argmax(axis=1)
            d[some], n[some] = beyond[np.arange(len(some)), face], normals[face]
        d[boxes], n[boxes] = in_front
        seen = ~behind | (np.einsum("ij,ij->i", n, local - eye) < 0.0)
        return d, np.einsum("nij,nj->ni", R, n), seen


def _pierced(start: Array, end: Array, half: Array) -> Mask:
    """(N,) which line segments meet the box (N, 3) centred on their frame (slab method)."""
    enter, leave = _slabs(start, end, half)
    met: Mask = (enter < leave) & (enter > 0.0) & (enter < 1.0)
    return met


def _slabs(start: Array, end: Array, half: Array) -> tuple[Array, Array]:
    """(...) shares of segments at which they enter boxes and leave them; see `_pierced`."""
    way = end - start
    way = np.where(np.abs(way) < 1e-12, 1e-12, way)
    one, two = (-half - start) / way, (half - start) / way
    return np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)


def _from_visible_faces(points: Array, eyes: Array, half: Array) -> tuple[Array, Array]:
    """Distance (N,) of the nearest plane of a face that an eye outside sees, and normals (N, 3)."""
    side, rows = np.sign(eyes), np.arange(len(points))
    beyond = np.where(np.abs(eyes) > half, side * points - half, -np.inf)
    face = beyond.argmax(axis=1)
    normals = np.zeros_like(points)
    normals[rows, face] = side[rows, face]
    return beyond[rows, face], normals


def _faces(hull: Hull) -> tuple[Array, Array]:
    """Outward normals (F, 3) of the planes of a hull and their offsets (F,) [m]."""
    a, b, c = hull.vertices[hull.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("fi,fi->f", normals, a)
