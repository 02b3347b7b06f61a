"""The picture of a tree has everything that a task says."""

from everything import write_everything

from trees.draw import tree_text
from trees.language import load


def test_the_text_has_a_line_a_node_with_name_arguments_and_modifiers(tmp_path):
    path = tmp_path / "t.yaml"
    pick = "{name: pick, retry: $tries, fallback: [holding_object, open_gripper]}"
    go = "{while: arm_healthy, force: success, navigate: {to: home, speed_m_s: 0.5}}"
    path.write_text(
        "task: t\nparams: {tries: {default: 3}}\n"
        "poses: {home: {base: [0, 0], heading_deg: 0}}\n"
        f"tree: {{sequence: [{pick}, {go}]}}\n"
    )
    assert tree_text(load(path, open_parameters=True).root) == (
        "→ sequence\n"
        "├─ ? pick (fallback)  [retry: $tries]\n"
        "│  ├─ ○ holding_object\n"
        "│  └─ • open_gripper\n"
        "└─ • navigate  to: home  speed_m_s: 0.5  [while: arm_healthy]  [force: success]\n"
    )


def test_a_task_with_every_word_can_be_drawn(tmp_path):
    task = load(write_everything(tmp_path), open_parameters=True)
    text = tree_text(task.root)
    assert all(name in text for name in ("▣", "cases: ", " → $", "[while: "))
    assert text.count("\n") == len(text.splitlines())
