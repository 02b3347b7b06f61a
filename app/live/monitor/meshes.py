"""Meshes of the Panda, its hand and the Omron base, if the extra `assets` is installed.

The package rtb-data provides them. They are reduced to about a tenth of their triangles, because
every recording contains them, and cached in the user's cache folder.
"""

import importlib.util
import os
from contextlib import suppress
from dataclasses import dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from config import user_cache
from config.arrays import Image

NAMES = (*(f"link{i}" for i in range(8)), "hand", "finger", "omron")
"""Names of the meshes, each in its link's frame; the origin of `omron` is on the floor."""

_FOLDER = Path("xacro/qut_frankie_description/meshes/visual")
_EXTRA = ("rtbdata", "trimesh", "collada", "fast_simplification", "networkx", "scipy")
_KEPT, _KEPT_OF_BASE = 0.18, 0.06
"""Share of the triangles that is kept; the base's mesh is finer than the arm's."""
_FEWEST = 80
_HARD_EDGE = np.radians(35.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A coloured triangle mesh."""

    vertices: Image  # (N, 3) [m]
    normals: Image  # (N, 3) of the vertices
    colours: npt.NDArray[np.uint8]  # (N, 3) of the vertices
    triangles: npt.NDArray[np.uint32]  # (M, 3) indices of vertices


_PARTS = [field.name for field in fields(Mesh)]


def meshes() -> dict[str, Mesh] | None:
    """The meshes by name; None without the `assets` extra."""
    if any(importlib.util.find_spec(package) is None for package in _EXTRA):
        return None
    kept = user_cache() / f"frankie-meshes-{version('rtb-data')}.npz"
    with suppress(OSError, KeyError, ValueError, BadZipFile), np.load(kept) as arrays:
        return {name: Mesh(**{part: arrays[f"{name}.{part}"] for part in _PARTS}) for name in NAMES}
    made = {name: _thinned(name) for name in NAMES}
    arrays = {f"{name}.{part}": getattr(made[name], part) for name in NAMES for part in _PARTS}
    draft = kept.with_suffix(f".{os.getpid()}.npz")
    with suppress(OSError):  # without a cache they are made again next time
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(draft, **arrays)
        draft.replace(kept)
    return made


def _thinned(name: str) -> Mesh:
    import fast_simplification
    import rtbdata
    import trimesh

    share = _KEPT_OF_BASE if name == "omron" else _KEPT
    vertices, normals, colours, triangles, count = [], [], [], [], 0
    pieces: Any = trimesh.load_scene(Path(rtbdata.__path__[0]) / _FOLDER / f"{name}.dae").dump()
    for piece in pieces:
        piece.merge_vertices(merge_norm=True, merge_tex=True)
        colour = getattr(piece.visual, "material", piece.visual).main_color[:3]
        fewest = min(len(piece.faces), _FEWEST)
        thin_vertices, thin_faces = fast_simplification.simplify(
            np.asarray(piece.vertices, np.float32),
            np.asarray(piece.faces),
            target_count=max(fewest, round(share * len(piece.faces))),
        )
        mesh = trimesh.Trimesh(thin_vertices, thin_faces, process=False)
        mesh.update_faces(mesh.nondegenerate_faces())
        smooth = trimesh.graph.smooth_shade(mesh, angle=float(_HARD_EDGE))
        vertices.append(smooth.vertices)
        normals.append(smooth.vertex_normals)
        colours.append(np.tile(colour, (len(smooth.vertices), 1)))
        triangles.append(smooth.faces + count)
        count += len(smooth.vertices)
    return Mesh(
        vertices=np.concatenate(vertices).astype(np.float32),
        normals=np.concatenate(normals).astype(np.float32),
        colours=np.concatenate(colours).astype(np.uint8),
        triangles=np.concatenate(triangles).astype(np.uint32),
    )
