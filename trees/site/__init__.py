"""Whether a task can be done where it is meant to be: by a robot, in a scene.

`check` names what the language alone cannot know: postures outside of the joints' limits, hands out
of reach, below the floor or inside furniture, regions without a surface, scenes that there are not.
"""

from trees.site.check import check, place_diagnostics, scene_of

__all__ = ["check", "place_diagnostics", "scene_of"]
