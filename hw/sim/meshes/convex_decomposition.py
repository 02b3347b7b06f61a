"""Convex decomposition of a mesh: exact where its bodies are convex, else V-HACD, cached.

V-HACD (Mamou 2016) fills the surface with voxels and cuts them by planes. Neighbouring pieces are
then merged as long as their common hull adds next to no volume.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path

import numpy as np

from config import extra, user_cache
from hw.sim.meshes.mesh_file import MeshError
from hw.sim.meshes.shaping import (
    components,
    enclosed,
    is_closed,
    simplified,
    with_holes_filled,
)
from hw.sim.sim_object import Mesh
from robots import Array, Geom, Triangles, hull_of, volume

_RECIPE = "2"  # version of the method, part of the cache key
_CONVEX = 1.02  # largest volume of the hull of a convex body, relative
_ADDS = 0.003  # two pieces are merged if their hull adds less than this share of the hull of all
_MOST_BODIES = 64
_MOST_PIECES, _VOXELS = 48, 150_000
_MOST_CORNERS = 64  # of a part that was not split
_SIMPLE = 8000  # largest number of triangles that are split
_PATIENCE = 180.0  # timeout of splitting [s]


def convex_parts(mesh: Mesh, name: str = "a mesh") -> tuple[Geom, ...]:
    """Hulls that fill a mesh, in its frame, cached by content; MeshError: it is not split."""
    content = hashlib.sha256(_RECIPE.encode())
    size = float(np.ptp(mesh.vertices, axis=0).max())
    content.update(np.round(mesh.vertices / size, 6).tobytes() + mesh.triangles.tobytes())
    file = user_cache() / "convex-parts" / f"{content.hexdigest()[:32]}.npz"
    hulls = _load(file)
    if hulls is None:
        hulls = _decompose(mesh.vertices / size, mesh.triangles, name)
        _save(file, hulls)
    return tuple(hull_of(size * corners) for corners in hulls)


def _decompose(vertices: Array, triangles: Triangles, name: str) -> list[Array]:
    """Corners of the hulls of a mesh of size 1."""
    bodies = components(vertices, triangles)
    if len(bodies) <= _MOST_BODIES and all(_is_convex(*body) for body in bodies):
        return [_extreme_corners(corners) for corners, _ in bodies]
    print(f"{name} is cut into convex parts; only this once", file=sys.stderr, flush=True)
    filled = with_holes_filled(*simplified(vertices, triangles, _SIMPLE))
    pieces = [corners for corners in _split(*filled) if _has_volume(corners)]
    if not pieces:
        raise MeshError("it encloses nothing; close its holes")
    return _merged(pieces)


def _is_convex(vertices: Array, triangles: Triangles) -> bool:
    if not is_closed(vertices, triangles) or not _has_volume(vertices):
        return False
    return volume(hull_of(vertices).shape) < _CONVEX * abs(enclosed(vertices, triangles))


def _has_volume(points: Array) -> bool:
    try:
        return volume(hull_of(points).shape) > 1e-9
    except ValueError:
        return False


def _extreme_corners(corners: Array) -> Array:
    """The corners that reach farthest in evenly distributed directions, if there are too many."""
    if len(corners) <= _MOST_CORNERS:
        return corners
    numbers = np.arange(4 * _MOST_CORNERS) + 0.5
    height = 1.0 - 2.0 * numbers / len(numbers)
    turn, across = np.pi * (1.0 + 5.0**0.5) * numbers, np.sqrt(1.0 - height**2)
    ways = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
    farthest = np.unique((corners @ np.concatenate([np.eye(3), -np.eye(3), ways]).T).argmax(0))
    return np.asarray(corners[farthest])


def _merged(pieces: list[Array]) -> list[Array]:
    hulls = list(pieces)
    sizes = [volume(hull_of(piece).shape) for piece in hulls]
    whole = volume(hull_of(np.concatenate(hulls)).shape)
    added: dict[tuple[int, int], float] = {}
    alive = set(range(len(hulls)))
    while len(alive) > 1:
        for a, b in combinations(sorted(alive), 2):
            if (a, b) not in added:
                both = volume(hull_of(np.concatenate([hulls[a], hulls[b]])).shape)
                added[a, b] = both - sizes[a] - sizes[b]
        (a, b), least = min(added.items(), key=lambda entry: (entry[1], entry[0]))
        if least > _ADDS * whole:
            break
        joined = hull_of(np.concatenate([hulls[a], hulls[b]]))
        corners = joined.shape.vertices + joined.pose.translation  # type: ignore[union-attr]
        hulls.append(_extreme_corners(corners))
        sizes.append(volume(joined.shape))
        alive = alive - {a, b} | {len(hulls) - 1}
        added = {pair: more for pair, more in added.items() if not {a, b} & set(pair)}
    return [hulls[number] for number in sorted(alive)]


def _split(vertices: Array, triangles: Triangles) -> list[Array]:
    """Corners of convex pieces, from a subprocess that may crash or time out."""
    if find_spec("vhacdx") is None:
        raise MeshError(f"it is not convex; splitting it needs {extra('meshes')}")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "mesh.npz"), Path(folder, "hulls.npz")
        np.savez(source, vertices=vertices, triangles=triangles)
        script = Path(__file__).with_name("split.py")
        numbers = str(_MOST_PIECES), str(_VOXELS)
        command = [sys.executable, "-P", str(script), str(source), str(target), *numbers]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_PATIENCE)
            with np.load(target) as found:
                return [found[str(number)] for number in range(len(found))]
        except (subprocess.SubprocessError, OSError) as error:
            raise MeshError(
                "it cannot be split into convex parts; repair it, or save it with fewer triangles"
            ) from error


def _load(file: Path) -> list[Array] | None:
    try:
        with np.load(file, allow_pickle=False) as found:
            hulls = [np.asarray(found[str(number)], dtype=float) for number in range(len(found))]
    except Exception:  # not there, or not whole: it is made again
        return None
    is_whole = hulls and all(hull.ndim == 2 and _has_volume(hull) for hull in hulls)
    return hulls if is_whole else None


def _save(file: Path, hulls: list[Array]) -> None:
    """Write atomically; without write permission nothing is cached."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".npz", delete=False) as draft:
            np.savez(draft, **{str(number): hull for number, hull in enumerate(hulls)})  # type: ignore[arg-type]
        os.replace(draft.name, file)
    except OSError:
        return
