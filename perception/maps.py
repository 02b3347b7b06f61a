"""What the maps of the networks mean, for those that make them and those that read them."""

from config import UserError

SIZE = 300
"""Side of the square that a network sees [px]."""
STRIDE = 3
"""Network pixels to a cell of the labels, and of the maps of `AngleBinNetwork`."""
CELLS = SIZE // STRIDE
"""Side of the grid of labels."""
BINS = 16
"""Closing directions that are told apart: bin i is i π / 16, anticlockwise as seen."""
WIDTH_SCALE = 150.0
"""A width map is the opening in network pixels divided by this, as published."""


class WeightsError(UserError):
    """Weights that are missing or do not fit the network; the text says how to fix it."""
