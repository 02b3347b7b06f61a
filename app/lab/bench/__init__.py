"""What the controller and the whole robot are worth, measured by commands that anybody can repeat.

The controller's motions are integrated without error and judged by measures of their own, apart
from those that it keeps: joint and base limits, contacts, arrival, jerk. `pick_place` counts what
the main job brings to the table.
"""
