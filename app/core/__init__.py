"""The core: one task, one robot, one loop, and what a run leaves."""
