"""Objects in a region: segmentation of a depth image, colours and classes."""
