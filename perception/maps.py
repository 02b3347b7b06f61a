"""What the maps of the network mean, for those that make them and those that read them."""

SIZE = 300
"""Side of the square that the network sees, and of its maps [px]."""
WIDTH_SCALE = 150.0
"""The width map is the opening in network pixels divided by this, as published."""


class WeightsError(Exception):
    """Weights that are missing or do not fit the network; the text says how to mend it."""
