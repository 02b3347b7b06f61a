"""Two task files, one with the other as a subtree, and the errors of changed ones."""

from __future__ import annotations

from pathlib import Path

from tree_toys import TOYS

from trees.language import check

PART = """\
task: part
params:
  to: {type: pose, description: where to}
  times: {default: 2}
outputs: {done: how often}
poses: {aside: {base: [0, 0], heading_deg: 0}}
tree:
  sequence:
    - {retry: $times, navigate: {to: $to}}
    - navigate: {to: aside}
    - count: {times: done}
"""
TOP = """\
task: top
params: {goal: {type: pose, default: home}}
poses: {home: {base: [1, 2], heading_deg: 0}}
tree:
  sequence:
    - subtree: {file: parts/part.yaml, with: {to: $goal}, out: {done: n}}
    - name: again
      retry: 2
      subtree: {file: parts/part.yaml, with: {to: home, times: 5}, out: {done: m}}
    - note: {value: $n}
    - note: {value: $m}
"""


def write_files(folder: Path) -> Path:
    (folder / "parts").mkdir()
    (folder / "parts" / "part.yaml").write_text(PART)
    (folder / "top.yaml").write_text(TOP)
    return folder


def errors(folder, top: str = TOP, part: str = PART) -> list[str]:
    (folder / "top.yaml").write_text(top)
    (folder / "parts" / "part.yaml").write_text(part)
    found = check(folder / "top.yaml", leaves=TOYS)
    return [str(diagnostic).removeprefix(f"{folder}/") for diagnostic in found]
