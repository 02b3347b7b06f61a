"""Names for the kinds of arrays that perception passes around."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Geometry."""
Image: TypeAlias = npt.NDArray[np.float32]
"""Depth, heights, maps."""
FloatArray: TypeAlias = npt.NDArray[np.floating]
"""Either."""
Mask: TypeAlias = npt.NDArray[np.bool_]
"""Yes or no for each element."""
Indices: TypeAlias = npt.NDArray[np.int64]
"""Positions in another array."""
