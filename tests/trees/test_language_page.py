"""The page about the language has every word, and its examples are sound."""

from __future__ import annotations

import re
from pathlib import Path

from trees.language import COMPOSITES, MODIFIERS, Severity, check
from trees.language.documents import FILE_KEYS
from trees.language.value_types import PARAMETER_TYPES

PAGE = (Path(__file__).parents[2] / "docs" / "language.md").read_text()
AROUND = """\
task: example
poses: {above_box: {xyz: [1, 0, 1], rpy_deg: [180, 0, 0]}}
regions: {box: {centre: [1, 0, 0.5], size: [1, 1, 0.2]}}
tree:
  sequence:
"""
PART = """\
task: pick
params: {from: {type: pose}, attempts: {default: 2}}
outputs: {picked: how many}
tree: {retry: $attempts, sequence: [navigate: {to: $from}, set: {picked: 1}]}
"""


def test_every_word_is_explained():
    told = set(re.findall(r"[a-z_]+", PAGE))
    assert {*COMPOSITES, *FILE_KEYS, *PARAMETER_TYPES} <= told


def test_modifiers_are_told_in_the_order_in_which_they_wrap():
    assert re.findall(r"^\| `([a-z_]+): ", PAGE, re.MULTILINE) == list(MODIFIERS)


def test_the_examples_are_sound(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "pick.yaml").write_text(PART)
    examples = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    assert len(examples) == 3
    for example in examples:
        lines = "".join(f"    {line}\n" for line in example.splitlines())
        (tmp_path / "example.yaml").write_text(AROUND + lines)
        found = check(tmp_path / "example.yaml")
        assert [diagnostic for diagnostic in found if diagnostic.severity is Severity.ERROR] == []
