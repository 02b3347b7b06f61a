"""Behaviours: the leaves of task trees, each in the file of its key, conditions in `conditions`.

Leaves read the state and set one motion goal a tick in the `Context` that they share; they never
command motion themselves. `LEAVES` has them by key.
"""

from typing import TYPE_CHECKING

from behaviours.core.errors import LeafCrashedError
from behaviours.core.parameter_types import (
    BasePose,
    Bounds,
    Count,
    Key,
    MapPlace,
    NotNegative,
    Percent,
    Positive,
    Posture,
    Region,
    ToolPose,
)
from perception import DetectedObject, DetectedObjects

if TYPE_CHECKING:
    from behaviours.face import *
else:

    def __getattr__(name: str) -> object:
        import behaviours.face

        return getattr(behaviours.face, name)
