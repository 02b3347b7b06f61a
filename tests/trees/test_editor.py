"""What an editor shows while a task is written, asked of the language server that editors use."""

from __future__ import annotations

import shutil

import pytest
from language_server import VERSION, LanguageServer, find_server

from trees import SCHEMA_FILE
from trees.language import COMPOSITES, MODIFIERS

SERVER = find_server()
pytestmark = pytest.mark.skipif(
    SERVER is None,
    reason=f"yaml-language-server {VERSION} is not installed: `make language-server` does it",
)

TASK = (
    f"""\
# yaml-language-server: $schema={SCHEMA_FILE.name}
task: written
poses:
  there: {{base: [1, 2], heading_deg: 0}}
tree:
  sequence:
    - navigate: {{to: there, speed_m_s: fast}}
    - name: wait a little
      retry: 0
      wait: {{duration_s: 2}}
    - navigat: {{to: there}}
    - drive: {{forward_m: 1500}}
    - while: {{all_of: [arm_helthy]}}
      open_gripper:
    - grasp: {{within: box, choose: bigest}}
    - add: {{tries: many}}
    - detect:
        region: box
        list: found
        choose:{" "}
    - grasp:
        lock_distance_m: 0.2
{" " * 8}
    - open_gripper
    -"""
    + " \n"
)


@pytest.fixture(scope="module")
def server():
    with LanguageServer(str(SERVER)) as running:
        yield running


@pytest.fixture(scope="module")
def task(tmp_path_factory, server):
    """A file that is being written, open in the editor; the path and what is underlined."""
    folder = tmp_path_factory.mktemp("editor")
    shutil.copy(SCHEMA_FILE, folder)
    path = folder / "written.yaml"
    path.write_text(TASK, encoding="utf-8")
    return path, server.open(path)


def line_of(text: str) -> int:
    return next(n for n, line in enumerate(TASK.splitlines(keepends=True), start=1) if text in line)


def test_mistakes_are_underlined_where_they_are(task):
    _, diagnostics = task
    starts = {
        (found["range"]["start"]["line"] + 1, found["range"]["start"]["character"] + 1)
        for found in diagnostics
    }
    assert (line_of("fast"), 40) in starts
    assert (line_of("retry"), 14) in starts
    assert (line_of("navigat:"), 7) in starts
    assert (line_of("grasp:\n"), 7) in starts
    assert (line_of("forward_m"), 26) in starts
    assert (line_of("arm_helthy"), 24) in starts
    assert (line_of("bigest"), 36) in starts
    assert (line_of("tries: many"), 20) in starts
    assert not any(line == line_of("wait:") for line, _ in starts)


def test_a_new_item_is_offered_every_node_and_modifier_once(server, task):
    path, _ = task
    offered = server.completion(path, len(TASK.splitlines()), 7)
    assert len(offered) == len(set(offered))
    assert {"navigate", "grasp", "open_gripper", *COMPOSITES, *MODIFIERS} <= set(offered)


def test_below_a_leaf_its_parameters_are_offered(server, task):
    path, _ = task
    offered = server.completion(path, line_of("lock_distance_m") + 1, 9)
    assert {"within", "force_n", "patience_s"} <= set(offered)
    assert "navigate" not in offered


def test_after_a_parameter_its_values_are_offered(server, task):
    path, _ = task
    offered = server.completion(path, line_of("choose: \n"), 17)
    assert {"best", "largest", "smallest", "nearest"} <= set(offered)


@pytest.mark.parametrize(
    ("text", "column", "said"),
    [
        ("- navigate", 9, "to a named pose"),
        ("retry", 9, "number of attempts"),
        ("choose: bigest", 30, "which of those that fit"),
    ],
)
def test_pointing_at_a_word_explains_it(server, task, text, column, said):
    path, _ = task
    assert said.lower() in server.hover(path, line_of(text), column).lower()
