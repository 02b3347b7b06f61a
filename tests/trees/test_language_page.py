"""The page about the language has every word, and its examples are sound."""

import re
from pathlib import Path

from tree_toys import check

from config import Severity
from trees.language import COMPOSITES, FILE_KEYS, MODIFIERS, PARAMETER_TYPES

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


def table(head: str) -> list[str]:
    """The first words in the rows of the table with this head."""
    _, _, rows = PAGE.partition(f"\n| {head} |")
    cells = [line.split("|")[1] for line in rows.split("\n\n")[0].splitlines()[2:]]
    return [word for cell in cells for word in re.findall(r"`([a-z_]+)", cell)]


def test_every_word_has_its_row_in_the_order_of_the_language():
    assert table("composite") == list(COMPOSITES)
    assert table("modifier") == list(MODIFIERS)
    assert table("key") == list(FILE_KEYS)


def test_every_type_of_parameter_is_explained():
    assert set(PARAMETER_TYPES) <= set(re.findall(r"`([a-z_]+)`", PAGE))


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
