"""Checks of a task with a robot and a scene: joint limits, reach, collisions and surfaces."""

from trees.site.check import check, furniture_diagnostics, place_diagnostics, scene_of
from trees.site.site_rules import RULES
