"""A small task file to put mistakes into, and the errors of what comes of it."""

from tree_toys import TOYS

from config import Severity
from trees.language import check

HEAD = """\
task: toy
params:
  count: {default: 3, description: how many}
  speed: {default: 1.5}
poses:
  home: {xyz: [1, 2, 3], rpy_deg: [180, 0, 0]}
  dock: {base: [0, 0], heading_deg: 90}
  folded: {joints_deg: [0, -17, 0, -126, 0, 115, 45]}
regions:
  box: {centre: [0, 0, 0.5], size: [1, 1, 0.2]}
tree:
"""
FIRST = HEAD.count("\n") + 1
"""The line of the file on which the tree begins."""
TREE = "tree: open_gripper\n"


def errors(folder, text: str, **options) -> list[str]:
    path = folder / "t.yaml"
    path.write_text(text)
    found = check(path, leaves=TOYS, **options)
    return [
        str(diagnostic).removeprefix(f"{path}:")
        for diagnostic in found
        if diagnostic.severity is Severity.ERROR
    ]
