"""The ChArUco board: its print, and its corners in an image."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config.arrays import Array
from robots import Intrinsics

Grey = npt.NDArray[np.uint8]

_FEWEST = 8  # corners that a view must show


@dataclass(frozen=True)
class Board:
    """A chessboard whose white squares carry markers of the dictionary 4X4_50.

    Its frame m: the origin in the outer corner beside marker 0, x along the columns, y along the
    rows, z into the board.
    """

    columns: int = 7
    rows: int = 5
    square: float = 0.04  # edge of a square [m]
    marker: float = 0.03  # edge of a marker [m]

    @cached_property
    def pattern(self) -> Any:
        """The board of OpenCV."""
        markers = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        size = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(size, self.square, self.marker, markers)

    @cached_property
    def corners(self) -> Array:
        """(N, 3) inner corners of the chessboard, in m [m]."""
        return np.asarray(self.pattern.getChessboardCorners(), dtype=float)

    @property
    def size(self) -> tuple[float, float]:
        """Of the whole board [m]."""
        return self.columns * self.square, self.rows * self.square

    @property
    def centre(self) -> Array:
        """(3,) in m [m]."""
        return np.array([*self.size, 0.0]) / 2.0

    def picture(self, pixels_per_square: int) -> Grey:
        """The board as it is printed, without a margin."""
        size = (self.columns * pixels_per_square, self.rows * pixels_per_square)
        return np.asarray(self.pattern.generateImage(size, marginSize=0), dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of the board found in one image."""

    board: Array  # (N, 3) on the board [m]
    image: Array  # (N, 2) in the image [px]


def find_corners(image: Grey, board: Board) -> Corners | None:
    """The corners of the board in an (H, W) image; None if too few are seen."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.CharucoDetector(
        board.pattern, cv2.aruco.CharucoParameters(), parameters, cv2.aruco.RefineParameters()
    )
    found, numbers, _, _ = detector.detectBoard(image)
    if numbers is None or len(numbers) < _FEWEST:
        return None
    pixels = np.asarray(found, dtype=float).reshape(-1, 2)
    return Corners(board.corners[np.asarray(numbers).ravel()], pixels)


def pose_of(corners: Corners, camera: Intrinsics) -> SE3:
    """cTk, the board in the camera's frame, from its corners in one image."""
    _, turn, shift = cv2.solvePnP(
        corners.board, corners.image, camera.matrix, None, flags=cv2.SOLVEPNP_IPPE
    )
    turn, shift = cv2.solvePnPRefineLM(
        corners.board, corners.image, camera.matrix, None, turn, shift
    )
    return SE3(cv2.Rodrigues(turn)[0], shift.ravel())


def project(cTk: SE3, points: Array, camera: Intrinsics) -> Array:
    """(N, 2) pixels of points (N, 3) of the board [m]."""
    seen = points @ cTk.rotation.T + cTk.translation
    pixels: Array = seen[:, :2] / seen[:, 2:] * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    return pixels
