"""Reaching goals among obstacles: seeded worlds, trials, an independent judge, the report."""
