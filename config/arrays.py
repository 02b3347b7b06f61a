"""Types of arrays."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]  # geometry in double precision
Image: TypeAlias = npt.NDArray[np.float32]  # depth, heights and network maps in single precision
Picture: TypeAlias = npt.NDArray[np.uint8]  # grey or colours
Mask: TypeAlias = npt.NDArray[np.bool_]
Indices: TypeAlias = npt.NDArray[np.int64]
