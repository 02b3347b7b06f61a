"""Exported tasks: BehaviorTree.CPP itself runs them, and what its XML cannot say is refused."""

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from everything import FOLDER, write_everything

import trees
from extensions.export.btcpp import export_xml
from trees.language import TaskFileError, load

bt = pytest.importorskip("behaviortreepy", reason="it has no wheels for this Python")

SHIPPED = sorted(Path(trees.__file__).parent.glob("*.yaml"))
EXPECTED = FOLDER / "everything.xml"
ALIKE = yaml.safe_load((Path(__file__).parent / "cpp.yaml").read_text("utf-8"))


def exported(path: Path) -> str:
    return export_xml(load(path, open_parameters=True))


def write(folder: Path, tree: str, sections: str = "") -> Path:
    path = folder / "t.yaml"
    indented = "\n".join(f"  {line}" for line in tree.strip().splitlines())
    path.write_text(f"task: t\n{sections}tree:\n{indented}\n")
    return path


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


def test_bt_cpp_creates_a_task_with_every_word(tmp_path):
    cpp = Cpp(exported(write_everything(tmp_path)))
    assert {"Main", "everything", "count"} <= set(cpp.factory.registered_behavior_trees())


@pytest.mark.parametrize(
    ("failures", "outcome", "grasps"), [(0, "success", 1), (2, "success", 3), (9, "failure", 3)]
)
def test_bt_cpp_runs_a_task_to_the_same_end(failures, outcome, grasps):
    cpp = Cpp(exported(trees.shipped("pick_one")), grasp=failures)
    assert cpp.run() == outcome
    assert cpp.ticks["grasp"] == grasps
    assert cpp.ticks["place"] == (outcome == "success")


@pytest.mark.parametrize("row", ALIKE, ids=lambda row: row["tree"])
def test_a_word_means_in_bt_cpp_what_it_means_here(tmp_path, row):
    from app.authoring import dry_run

    path, failing = write(tmp_path, row["tree"]), row["failing"]
    assert Cpp(exported(path), **failing).run() == row["outcome"]
    scripted = [f"{key}={'failure,' * count}success" for key, count in failing.items()]
    here = dry_run(path, outcomes=scripted, overrides={})
    assert here.outcome.end.value == row["outcome"]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_bt_cpp_creates_every_shipped_task_and_every_node_has_a_model_with_all_its_ports(path):
    Cpp(exported(path))
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


def test_the_trees_of_a_task_with_every_word_are_those_that_were_looked_at(tmp_path):
    """`everything.xml` is read by eye; what it says of each word is the documentation's table."""
    root, expected = (
        ElementTree.fromstring(text)
        for text in (exported(write_everything(tmp_path)), EXPECTED.read_text(encoding="utf-8"))
    )
    for own, looked_at in zip(root.findall("BehaviorTree"), expected, strict=True):
        assert ElementTree.canonicalize(
            ElementTree.tostring(own), strip_text=True
        ) == ElementTree.canonicalize(ElementTree.tostring(looked_at), strip_text=True)


@pytest.mark.parametrize(
    ("tree", "location", "message"),
    [
        ('compare: {value: "{key}", equals: a}', "4:3", "read '{key}' as something else"),
        ("sequence:\n  - set: {k: it's}\n  - say: {text: $k}", "5:7", "a script cannot write"),
    ],
)
def test_what_the_xml_cannot_say_in_a_node_is_refused_where_it_stands(
    tmp_path, tree, location, message
):
    path = write(tmp_path, tree)
    path.write_text(path.read_text().replace("task: t\n", "task: t\ndescription: d\n"))
    with pytest.raises(TaskFileError) as refused:
        exported(path)
    assert str(refused.value).startswith(f"{path}:{location}: ")
    assert message in str(refused.value)


def test_a_key_with_the_name_of_a_pose_is_refused(tmp_path):
    poses = "poses: {home: {base: [0, 0], heading_deg: 0}}\n"
    tree = "sequence:\n  - set: {home: 3}\n  - compare: {value: $home, equals: 3}"
    path = write(tmp_path, f"{tree}\n  - drive: {{to: home}}", poses)
    with pytest.raises(TaskFileError, match=r":5:7: `home` is a key and a pose"):
        exported(path)


def test_seconds_become_whole_milliseconds_whatever_their_rounding(tmp_path):
    for seconds in ("2.3", "0.1", "1.1", "600", "0.001"):
        text = exported(write(tmp_path, f"timeout_s: {seconds}\nopen_gripper:"))
        assert f'<Timeout msec="{round(1000 * float(seconds))}">' in text
    text = exported(write(tmp_path, "timeout_s: 0.0015\nopen_gripper:"))
    assert '<timeout_s value="0.0015">' in text


@pytest.mark.parametrize("name", ["Sequence", "grasp"])
def test_a_name_that_the_xml_needs_itself_is_refused(tmp_path, name):
    path = write(tmp_path, "open_gripper:" if name != "grasp" else "grasp: {within: r}")
    text = path.read_text().replace("task: t", f"task: {name}")
    path.write_text(text + "regions: {r: {centre: [0, 0, 0], size: [1, 1, 1]}}\n")
    with pytest.raises(TaskFileError, match="taken"):
        exported(path)
