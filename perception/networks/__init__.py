"""GG-CNN and the hold network: inference in NumPy, and their weights."""
