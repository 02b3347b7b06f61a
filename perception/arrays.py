"""Array types of perception."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Geometry in double precision."""
Image: TypeAlias = npt.NDArray[np.float32]
"""Depth, heights and network maps in single precision."""
FloatArray: TypeAlias = npt.NDArray[np.floating]
"""Either of them."""
Mask: TypeAlias = npt.NDArray[np.bool_]
"""One boolean per element."""
Indices: TypeAlias = npt.NDArray[np.int64]
"""Indices into another array."""
