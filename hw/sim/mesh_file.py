"""What a scene file says of a mesh: its file, its units, and which way is up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field, ValidationInfo, field_validator

from config import StrictModel
from hw.sim.meshes import MeshError, Units, Up, read_mesh
from hw.sim.surface import Mesh

Footprint = tuple[float, float]
"""Of the robot along x and y, where it starts: at the origin, with heading 0 [m]."""


class Reading(NamedTuple):
    """The context in which a scene file is read."""

    folder: Path  # Where the file is: its meshes are named from there
    footprint: Footprint | None  # None leaves the start unchecked


class MeshFile(StrictModel):
    """Something that may be a mesh; once it is read, the path of its file is an absolute one."""

    SIZES: ClassVar[tuple[float, float]] = (0.01, 10.0)
    """The smallest and the largest that its longest edge may be [m]."""

    units: Units = "m"  # Of the numbers in the file
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0  # By which it is made larger besides
    up: Up | None = None  # Which axis of the file points upwards; z, and y in a GLB file
    mesh: str | None = None  # The file: GLB, OBJ, OFF, PLY or STL

    @field_validator("mesh")
    @classmethod
    def _can_be_used(cls, mesh: str | None, info: ValidationInfo) -> str | None:
        if mesh is None or not {"units", "scale", "up"} <= set(info.data):
            return mesh
        if not mesh.isprintable() or not Path(mesh).name:
            raise ValueError("is no name of a file; write the path of a mesh")
        folder = info.context.folder if info.context else Path()
        path = str(folder / mesh)
        try:
            read_mesh(path, info.data["units"], info.data["scale"], info.data["up"], cls.SIZES)
        except MeshError as error:
            raise ValueError(f"{Path(mesh).name}: {error}") from error
        return path

    def read(self) -> Mesh:
        """The surface, the middle of its bounding box at the origin [m].

        Raises:
            MeshError: the file has changed since it was checked.
        """
        assert self.mesh is not None
        return read_mesh(self.mesh, self.units, self.scale, self.up, self.SIZES)
