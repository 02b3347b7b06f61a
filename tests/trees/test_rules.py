"""Every kind of diagnostic has a code, and an example that shows it."""

import pytest

from config import YAML_RULES
from extensions.export.btcpp import export_xml
from trees.language import LANGUAGE_RULES, TaskFileError, load
from trees.site import RULES, check


def codes(folder, example: str, *, exported: bool) -> set[str]:
    path = folder / "t.yaml"
    if "container:" not in example:
        is_tree = not example.startswith(("poses:", "params:", "scene:"))
        example = f"task: t\n{'tree: ' * is_tree}{example}\n"
    path.write_text(example)
    if not exported:
        return {one.rule.code for one in check(path)}
    try:
        export_xml(load(path))
    except TaskFileError as error:
        return {one.rule.code for one in error.diagnostics}
    return set()


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_the_wrong_example_breaks_its_rule_and_the_right_one_none(tmp_path, rule):
    exported = rule.code == "R601"
    assert rule.code in codes(tmp_path, rule.wrong, exported=exported)
    assert not codes(tmp_path, rule.right, exported=exported)


def test_no_two_rules_have_one_code():
    rules = {*YAML_RULES, *LANGUAGE_RULES, *RULES.values()}
    assert len({one.code for one in rules}) == len(rules)
