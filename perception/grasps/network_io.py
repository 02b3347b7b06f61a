"""The input and output of the grasp networks: sizes, directions and units."""

from config import UserError

INPUT_SIZE = 300
"""Side of a network's input image [px]."""
OUTPUT_STRIDE = 3
"""Input pixels per cell of the labels and of the maps of `AngleBinNetwork`."""
GRID_SIZE = INPUT_SIZE // OUTPUT_STRIDE
"""Side of the grid of labels [cells]."""
ANGLE_BINS = 16
"""Number of closing directions: bin i is i π / 16, anticlockwise in the image."""
WIDTH_SCALE = 150.0
"""A width map holds the opening divided by this, as published [input px]."""


class WeightsError(UserError):
    """Weights are missing or do not fit the network."""
