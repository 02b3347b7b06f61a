"""Exported tasks: BehaviorTree.CPP itself takes them, and nothing gets lost on the way back."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import behaviortreepy as bt
import numpy as np
import pytest
from everything import write_everything

import trees
from behaviours.named import BasePose, Posture, Region, ToolPose
from trees.btcpp import export_xml, import_xml
from trees.btcpp.words import STANDARD_COMPOSITES, STANDARD_MODIFIERS
from trees.language import Task, TaskFileError, load
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode
from trees.language.values import KeyRead

SHIPPED = sorted(Path(trees.__file__).parent.glob("*.yaml"))


def exported(path: Path) -> str:
    return export_xml(load(path, open_parameters=True))


def write(folder: Path, tree: str, sections: str = "") -> Path:
    path = folder / "t.yaml"
    indented = "\n".join(f"  {line}" for line in tree.strip().splitlines())
    path.write_text(f"task: t\n{sections}tree:\n{indented}\n")
    return path


# BehaviorTree.CPP reads it


class Cpp:
    """A tree of BehaviorTree.CPP made of exported XML, its leaves answered by a script.

    The bindings for Python can neither declare ports nor bring control nodes along. So the ports of
    the task's own nodes are left out here, and a control node of its own becomes a sequence;
    everything else is as exported.

    Args:
        xml: as exported.
        failures: how often each leaf fails before it succeeds.
    """

    def __init__(self, xml: str, **failures: int) -> None:
        self.ticks: Counter[str] = Counter()
        self._failures = failures
        root = ElementTree.fromstring(xml)
        models = {
            model.get("ID", ""): model.tag
            for model in root.find("TreeNodesModel")
            if model.tag != "SubTree"
        }
        for element in root.iter():
            if element.tag in models and element.get("ID") is None:
                for port in [key for key in element.attrib if key != "name"]:
                    del element.attrib[port]
                if models[element.tag] == "Control":
                    element.tag = "Sequence"
        self.factory = bt.BehaviorTreeFactory()
        for key, category in models.items():
            if category == "Decorator":
                self.factory.register_simple_decorator(key, lambda status, node: status)
            elif category != "Control":
                self.factory.register_simple_action(key, lambda node, key=key: self._answer(key))
        self.factory.register_behavior_tree_from_text(
            ElementTree.tostring(root, encoding="unicode")
        )
        self.tree = self.factory.create_tree(root.get("main_tree_to_execute"))

    def _answer(self, key: str) -> bt.NodeStatus:
        self.ticks[key] += 1
        failed = self.ticks[key] <= self._failures.get(key, 0)
        return bt.NodeStatus.FAILURE if failed else bt.NodeStatus.SUCCESS

    def run(self) -> str:
        """Tick until the tree ends; `running` if it does not."""
        for _ in range(50):
            status = self.tree.tick_exactly_once()
            if status != bt.NodeStatus.RUNNING:
                return str(status.name).lower()
        return "running"


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_bt_cpp_creates_every_shipped_task(path):
    Cpp(exported(path))


def test_bt_cpp_creates_a_task_with_every_word(tmp_path):
    cpp = Cpp(exported(write_everything(tmp_path)))
    assert {"Main", "everything", "count"} <= set(cpp.factory.registered_behavior_trees())


@pytest.mark.parametrize(
    ("failures", "outcome", "grasps"),
    [(0, "success", 1), (2, "success", 3), (9, "failure", 3)],
)
def test_bt_cpp_runs_a_task_to_the_same_end(failures, outcome, grasps):
    cpp = Cpp(exported(trees.shipped("pick_one")), grasp=failures)
    assert cpp.run() == outcome
    assert cpp.ticks["grasp"] == grasps
    assert cpp.ticks["place"] == (outcome == "success")


@pytest.mark.parametrize(
    ("tree", "failing", "outcome"),
    [
        ("fallback: [arm_healthy, open_gripper]", {"arm_healthy": 1}, "success"),
        ("sequence: [arm_healthy, open_gripper]", {"arm_healthy": 1}, "failure"),
        ("reactive_sequence: [arm_healthy, holding_object]", {"holding_object": 1}, "failure"),
        ("reactive_fallback: [arm_healthy, holding_object]", {"holding_object": 1}, "success"),
        ("parallel: [arm_healthy, holding_object]", {"holding_object": 9}, "failure"),
        (
            "parallel: {policy: any, children: [arm_healthy, holding_object]}",
            {"holding_object": 9},
            "success",
        ),
        (
            "parallel: {policy: 2, children: [arm_healthy, holding_object, open_gripper]}",
            {"holding_object": 9, "arm_healthy": 9},
            "failure",
        ),
        ("forever: open_gripper", {"open_gripper": 7}, "success"),
        ("retry: 3\nopen_gripper:", {"open_gripper": 2}, "success"),
        ("retry: 3\nopen_gripper:", {"open_gripper": 3}, "failure"),
        ("invert: true\nopen_gripper:", {}, "failure"),
        ("force_success: true\nopen_gripper:", {"open_gripper": 9}, "success"),
        ("force_failure: true\nopen_gripper:", {}, "failure"),
        ("once: true\nopen_gripper:", {"open_gripper": 9}, "failure"),
        ("retry: 2\nonce: true\nopen_gripper:", {"open_gripper": 1}, "success"),
        ("while: arm_healthy\nopen_gripper:", {"arm_healthy": 9}, "failure"),
        ("while: arm_healthy\nopen_gripper:", {}, "success"),
        ("unless: arm_healthy\nopen_gripper:", {"open_gripper": 9}, "success"),
        ("unless: arm_healthy\nopen_gripper:", {"arm_healthy": 9, "open_gripper": 9}, "failure"),
    ],
)
def test_a_word_means_in_bt_cpp_what_it_means_here(tmp_path, tree, failing, outcome):
    from app.authoring.dry import dry_run

    path = write(tmp_path, tree)
    assert Cpp(exported(path), **failing).run() == outcome
    scripted = [f"{key}={'failure,' * count}success" for key, count in failing.items()]
    here = dry_run(path, outcomes=scripted, overrides={}, most_ticks=100)
    assert here.outcome.end.value == outcome


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_node_has_a_model_with_all_its_ports(path):
    root = ElementTree.fromstring(exported(path))
    models = {model.get("ID"): model for model in root.find("TreeNodesModel")}
    trees_of = {tree.get("ID") for tree in root.iter("BehaviorTree")}
    for tree in root.iter("BehaviorTree"):
        for element in list(tree.iter())[1:]:
            key = element.get("ID") if element.tag == "SubTree" else element.tag
            if key in models:
                ports = {port.get("name") for port in models[key]}
                assert set(element.attrib) - {"name", "ID"} <= ports
                assert (key in trees_of) == (models[key].tag == "SubTree")
            else:
                assert key[0].isupper(), f"{key} is no node of BehaviorTree.CPP"


def test_the_documentation_names_every_word_with_its_counterpart():
    page = Path(trees.__file__).parents[1] / "docs" / "behaviortree_cpp.md"
    rows = [
        line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| `")
    ]
    for key, standard in (STANDARD_COMPOSITES | STANDARD_MODIFIERS).items():
        (row,) = [row for row in rows if f"`{key}`" in row.split("|")[1]]
        assert f"`{standard.tag}`" in row.split("|")[2]


# and nothing gets lost


def same(one: object, other: object) -> bool:
    """Whether two values of a task are the same, places in the file aside."""
    if isinstance(one, KeyRead) and isinstance(other, KeyRead):
        return one.name == other.name
    if type(one) is not type(other):
        return False
    if isinstance(one, ToolPose | BasePose | Region | Posture):
        poses = [getattr(one, key) for key in vars(one) if key != "name"]
        others = [getattr(other, key) for key in vars(other) if key != "name"]
        numbers = [np.asarray(getattr(thing, "homogeneous", thing)) for thing in (*poses, *others)]
        half = len(poses)
        return one.name == other.name and all(
            np.allclose(a, b, atol=1e-9)
            for a, b in zip(numbers[:half], numbers[half:], strict=True)
        )
    return same_node(one, other) if isinstance(one, LeafNode) else one == other


def same_items(one, other) -> bool:
    return list(one) == list(other) and all(same(one[key], other[key]) for key in one)


def same_node(one: Node, other: Node) -> bool:
    if type(one) is not type(other) or one.name != other.name:
        return False
    if not same_items(one.modifiers, other.modifiers):
        return False
    if isinstance(one, CompositeNode):
        children = zip(one.children, other.children, strict=True)
        return (
            one.key == other.key
            and same_items(one.options, other.options)
            and all(same_node(a, b) for a, b in children)
        )
    keys = [{name: key.name for name, key in node.outputs.items()} for node in (one, other)]
    if keys[0] != keys[1] or not same_items(one.arguments, other.arguments):
        return False
    if isinstance(one, SubtreeNode):
        return same_task(one.task, other.task)
    return one.type.key == other.type.key


def same_task(one: Task, other: Task) -> bool:
    def declared(task: Task):
        return {
            name: (p.type, p.default and p.default.value, p.description)
            for name, p in task.parameters.items()
        }

    return (
        (one.name, one.description, one.scene) == (other.name, other.description, other.scene)
        and declared(one) == declared(other)
        and same_items(one.poses, other.poses)
        and same_items(one.regions, other.regions)
        and {k: o.description for k, o in one.outputs.items()}
        == {k: o.description for k, o in other.outputs.items()}
        and same_node(one.root, other.root)
    )


def there_and_back(path: Path, folder: Path) -> Task:
    """The task that the import of a task's export makes."""
    xml = folder / "exported.xml"
    xml.write_text(exported(path), encoding="utf-8")
    texts = import_xml(xml)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return load(folder / next(iter(texts)), open_parameters=True)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_task_comes_back_the_same(path, tmp_path):
    assert same_task(load(path, open_parameters=True), there_and_back(path, tmp_path))


def test_a_task_with_every_word_comes_back_the_same(tmp_path):
    (tmp_path / "back").mkdir()
    path = write_everything(tmp_path)
    back = there_and_back(path, tmp_path / "back")
    assert same_task(load(path, open_parameters=True), back)


def test_the_comparison_sees_a_difference(tmp_path):
    """Else the two tests above could not fail."""
    (tmp_path / "other").mkdir()
    path = write_everything(tmp_path)
    one = load(path, open_parameters=True)
    text = path.read_text()
    for old, new in (
        ("retry: $tries", "retry: 3"),
        ("least: 1", "least: 2"),
        ("-2, 3]", "-2, 3.1]"),
        ("policy: any", "policy: all"),
        ("count the shelf", "count"),
        ("more", "less"),
    ):
        path.write_text(text.replace(old, new))
        assert not same_task(one, load(path, open_parameters=True)), new


# what it cannot say


@pytest.mark.parametrize(
    ("tree", "place", "said"),
    [
        ('say: {text: "{key}"}', "4:3", "read '{key}' as something else"),
        ('say: {text: "two\\nlines"}', "4:3", "as something else"),
        ("sequence:\n  - set: {k: it's}\n  - say: {text: $k}", "5:7", "a script cannot write"),
    ],
)
def test_what_the_xml_cannot_say_in_a_node_is_refused_where_it_stands(tmp_path, tree, place, said):
    path = write(tmp_path, tree)
    path.write_text(path.read_text().replace("task: t\n", "task: t\ndescription: d\n"))
    with pytest.raises(TaskFileError) as refused:
        exported(path)
    assert str(refused.value).startswith(f"{path}:{place}: ")
    assert said in str(refused.value)


def test_a_key_with_the_name_of_a_pose_is_refused(tmp_path):
    poses = "poses: {home: {base: [0, 0], heading_deg: 0}}\n"
    tree = "sequence:\n  - set: {home: 3}\n  - equals: {value: $home, to: 3}"
    path = write(tmp_path, f"{tree}\n  - drive: {{to: home}}", poses)
    with pytest.raises(TaskFileError, match=r":5:7: `home` is a key and a pose"):
        exported(path)


@pytest.mark.parametrize("choices", ['[left, "true"]', '[left, "a;b"]'])
def test_choices_that_the_xml_cannot_say_are_refused(tmp_path, choices):
    section = f"params: {{side: {{type: {choices}, default: left}}}}\n"
    path = write(tmp_path, "equals: {value: $side, to: left}", section)
    with pytest.raises(TaskFileError, match=r":2:10: the choice .* of `side`"):
        exported(path)


def test_seconds_become_whole_milliseconds_whatever_their_rounding(tmp_path):
    for seconds in ("2.3", "0.1", "1.1", "600", "0.001"):
        text = exported(write(tmp_path, f"timeout_s: {seconds}\nopen_gripper:"))
        assert f'<Timeout msec="{round(1000 * float(seconds))}">' in text
    text = exported(write(tmp_path, "timeout_s: 0.0015\nopen_gripper:"))
    assert '<timeout_s value="0.0015">' in text


@pytest.mark.parametrize("name", ["Main", "Sequence", "until", "grasp"])
def test_a_name_that_the_xml_needs_itself_is_refused(tmp_path, name):
    path = write(tmp_path, "open_gripper:" if name != "grasp" else "grasp: {within: r}")
    text = path.read_text().replace("task: t", f"task: {name}")
    path.write_text(text + "regions: {r: {centre: [0, 0, 0], size: [1, 1, 1]}}\n")
    with pytest.raises(TaskFileError, match="taken"):
        exported(path)
