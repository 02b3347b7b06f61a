"""The schema that editors use: current, complete, and of the same opinion as `check`."""

import json
from pathlib import Path
from typing import Any

import pytest
from everything import EVERYTHING, write_everything
from jsonschema import Draft7Validator
from mistakes import table
from tree_toys import check

import trees
from behaviours import LEAVES
from config import Diagnostics, content, parse_yaml
from trees import SCHEMA_FILE, schema_text
from trees.language import COMPOSITES, MODIFIERS, NAME, SUBTREE, describe_leaves

FOLDER = Path(trees.__file__).parent
SHIPPED = sorted(path for path in FOLDER.rglob("*.yaml") if not path.stem.endswith("_scene"))


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return json.loads(schema_text(describe_leaves(LEAVES)))


@pytest.fixture(scope="module")
def validator(schema) -> Draft7Validator:
    Draft7Validator.check_schema(schema)
    assert schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    return Draft7Validator(schema)


def parsed(text: str) -> Any:
    """The content of a task file as JSON has it; numbers and words as in YAML 1.2."""
    document = parse_yaml(text, Diagnostics(Path("t.yaml")))
    assert document is not None
    return content(document)


def test_every_word_is_offered_once_with_a_text_for_the_person_who_points_at_it(schema):
    offered = schema["definitions"]["node"]["properties"]
    words = {*LEAVES, *COMPOSITES, *MODIFIERS, NAME, SUBTREE, "set", "add"}
    assert set(offered) == words
    assert all(len(about["description"]) > 10 for about in offered.values())
    parameters = [
        (len(about["description"]), key, name)
        for key in LEAVES
        for name, about in offered[key].get("properties", {}).items()
    ]
    assert min(parameters)[0] >= 5, min(parameters)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_shipped_tasks_are_valid_and_name_the_schema_for_the_editor(validator, path):
    text = path.read_text(encoding="utf-8")
    assert list(validator.iter_errors(parsed(text))) == []
    first = text.splitlines()[0]
    _, equals, named = first.partition("# yaml-language-server: $schema=")
    assert equals
    assert (path.parent / named.strip()).resolve() == SCHEMA_FILE


def test_a_task_with_every_word_is_valid(validator, tmp_path):
    assert check(write_everything(tmp_path)) == []
    assert list(validator.iter_errors(parsed(EVERYTHING))) == []
    text = EVERYTHING.split("\ntree:")[1]
    unused = {word for word in (*COMPOSITES, *MODIFIERS, NAME, SUBTREE) if f"{word}:" not in text}
    assert unused == set(), "a word of the language that the sample does not use yet"


SOUND = {
    "task": "task: t\n",
    "poses": "poses: {above: {xyz: [1, 2, 3], rpy_deg: [180, 0, 0]}}\n",
    "tree": "tree: {navigate: {to: above}}\n",
}


@table("schema")
def test_what_is_wrong_is_refused_where_it_stands_and_by_check_too(validator, tmp_path, row):
    document = "".join((SOUND | {row["task"].split(":")[0]: row["task"] + "\n"}).values())
    where, errors = row["at"].split("/"), list(validator.iter_errors(parsed(document)))
    assert any(not row["at"] or list(error.path)[: len(where)] == where for error in errors), errors
    path = tmp_path / "t.yaml"
    path.write_text(document, encoding="utf-8")
    assert any(diagnostic.severity.value == "error" for diagnostic in check(path))
