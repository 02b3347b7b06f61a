"""Mesh files: read, checked, in metres, with z up and the middle at the origin."""

from functools import lru_cache
from os import listdir, stat
from os.path import dirname, isfile, realpath, splitext
from typing import Literal, TypeAlias

import numpy as np

from config import UserError, extra, quoted
from hw.sim.meshes.shaping import (
    enclosed,
    is_closed,
    simplified,
    welded,
    with_holes_filled,
)
from hw.sim.sim_object import Mesh
from robots import Array, Triangles

Units: TypeAlias = Literal["m", "cm", "mm", "in"]
Up: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"]

SUFFIXES = (".glb", ".obj", ".off", ".ply", ".stl")  # of supported files

METRES: dict[Units, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}

_LARGEST_FILE = 200_000_000
_MOST_READ = 1_000_000
_MOST_KEPT = 20_000  # triangles, after simplification
_MOST_DRAWN = 2500
_THINNEST = 2e-4  # [m]
_TURNS = {
    "x": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
    "-x": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]]),
    "-y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "-z": np.diag([1.0, -1.0, -1.0]),
}
"""Rotation that turns the axis of this name upwards."""
_NAMES: dict[Units, str] = {"mm": "millimetres", "m": "metres", "cm": "centimetres", "in": "inches"}
"""The most likely first."""


class MeshError(UserError):
    """A file that is no usable mesh; the text says what is wrong, and after `; ` a hint."""


def read_mesh(
    path: str, units: Units, scale: float, up: Up | None, sizes: tuple[float, float]
) -> Mesh:
    """The surface in a file, in metres, the middle of its bounding box at the origin.

    `up` is its axis that points upwards (None: z, in a GLB file y), `sizes` the range of its
    longest edge [m]. MeshError: there is no such file, or no usable mesh in it.
    """
    if not isfile(path):
        beside = _mesh_names(dirname(path))
        known = f"there are {quoted(beside[:8])}" if beside else "the path is relative to the scene"
        raise MeshError(f"there is no file {path}; {known}")
    status = stat(path)
    mesh, finest = _read(realpath(path), status.st_mtime_ns, status.st_size, up)
    factor = METRES[units] * scale
    _check_size(factor * finest, units, scale, sizes)
    return Mesh(mesh.vertices * factor, mesh.triangles, mesh.closed)


def _mesh_names(folder: str) -> list[str]:
    try:
        return sorted(name for name in listdir(folder or ".") if name.lower().endswith(SUFFIXES))
    except OSError:
        return []


def _check_size(extents: Array, units: Units, scale: float, sizes: tuple[float, float]) -> None:
    """Refuse what can be neither grasped nor seen, or is kilometres long."""
    longest, (smallest, largest) = float(extents.max()), sizes
    if not smallest <= longest <= largest:
        likely = [
            f"are these {name}? write `units: {unit}`"
            for unit, name in _NAMES.items()
            if smallest <= longest / METRES[units] * METRES[unit] <= largest
        ]
        hint = (likely or ["correct `units` or `scale`"])[0]
        between = f"{_length(smallest)} to {_length(largest)} are possible"
        raise MeshError(f"its longest edge is {_length(longest)}, and {between}; {hint}")
    if (thickness := float(extents.min())) < _THINNEST:
        raise MeshError(f"it is flat, {_length(thickness)} thick; make it 1 mm thick or more")


def fewer(mesh: Mesh) -> Mesh:
    """The visual mesh: simplified by a fraction of a millimetre, without holes."""
    filled = with_holes_filled(mesh.vertices, mesh.triangles)
    vertices, triangles = simplified(*filled, _MOST_DRAWN)
    return Mesh(vertices, triangles, is_closed(vertices, triangles))


@lru_cache(maxsize=64)
def _read(path: str, _changed: int, size: int, up: Up | None) -> tuple[Mesh, Array]:
    """The surface in units of the file, and the edges (3,) of its bounding box."""
    suffix = splitext(path)[1].lower()
    if suffix not in SUFFIXES:
        raise MeshError(f"`{suffix}` is no kind of mesh that is known; use {quoted(SUFFIXES)}")
    if size > _LARGEST_FILE:
        raise MeshError(
            f"the file is larger than {_LARGEST_FILE // 1_000_000} MB; save it with fewer triangles"
        )
    vertices, triangles = _triangles_of(path, suffix)
    if not len(triangles):
        raise MeshError("it has no triangles; is it a cloud of points? save it as a surface")
    if len(triangles) > _MOST_READ:
        raise MeshError(
            f"it has {len(triangles)} triangles, and {_MOST_READ} are possible; "
            "save it with fewer (20000 are plenty)"
        )
    vertices = vertices[triangles.ravel()]  # those alone that a triangle uses
    if not np.isfinite(vertices).all() or np.abs(vertices).max() > 1e12:
        raise MeshError("some of its corners are no numbers; save it again")
    triangles = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    vertices = vertices @ _TURNS[up or ("y" if suffix == ".glb" else "z")].T
    vertices, triangles = simplified(*welded(vertices, triangles), _MOST_KEPT)
    if not len(triangles):
        raise MeshError("all its triangles are without area; save it again")
    closed = is_closed(vertices, triangles)
    if closed and enclosed(vertices, triangles) < 0.0:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return Mesh(vertices - (low + high) / 2.0, triangles, closed), high - low


def _triangles_of(path: str, suffix: str) -> tuple[Array, Triangles]:
    try:
        import fast_simplification  # noqa: F401 (of the same extra; needed later)
        import trimesh
    except ImportError as error:
        raise MeshError(f"reading meshes needs an extra; {extra('meshes')}") from error
    try:
        with open(path, "rb") as file:  # no resolver: it opens no other file
            scene = trimesh.load_scene(
                file, file_type=suffix[1:], skip_materials=True, process=False
            )
        parts = [one for one in scene.dump() if isinstance(one, trimesh.Trimesh)]
        corners = [np.asarray(one.vertices, dtype=float)[one.faces] for one in parts]
    except Exception as error:  # whatever a broken file does to a reader
        reason = " ".join(str(error).split()) or type(error).__name__
        raise MeshError(f"it cannot be read: {reason[:120]}; is it a {suffix} file?") from error
    vertices = np.concatenate([np.zeros((0, 3)), *(one.reshape(-1, 3) for one in corners)])
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


def _length(metres: float) -> str:
    if metres >= 1000.0:
        return f"{metres / 1000.0:.3g} km"
    return f"{metres:.3g} m" if metres >= 1.0 else f"{1000.0 * metres:.3g} mm"
