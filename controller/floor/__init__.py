"""Navigation of the base: floor map, path planning, and driving."""
