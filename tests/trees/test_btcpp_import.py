"""XML by other hands: what has a counterpart is imported, the rest refused where it stands."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from everything import write_everything

from app.authoring.dry import dry_run
from trees.btcpp import export_xml, import_xml
from trees.language import TaskFileError, check, load

TREE = """\
<root BTCPP_format="4" main_tree_to_execute="fetch">
  <BehaviorTree ID="fetch">
    {}
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="fetch">
      <input_port name="tries" type="int" default="2"/>
      <input_port name="home" type="BasePose" default="base: 0 0; heading_deg: 90"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""


@pytest.fixture
def imported(tmp_path):
    """Imports the XML of a tree; gives the text of its file without the sections before."""

    def read(tree: str) -> str:
        path = tmp_path / "fetch.xml"
        path.write_text(TREE.format(tree), encoding="utf-8")
        (text,) = import_xml(path).values()
        (tmp_path / "fetch.yaml").write_text(text, encoding="utf-8")
        return text.partition("tree:\n")[2]

    return read


@pytest.fixture
def refused(tmp_path):
    """Tries to import an XML file; gives its complaints without the path."""

    def read(xml: str | bytes) -> list[str]:
        path = tmp_path / "bad.xml"
        path.write_bytes(xml.encode() if isinstance(xml, str) else xml)
        with pytest.raises(TaskFileError) as error:
            import_xml(path)
        lines = str(error.value).splitlines()
        assert all(line.startswith(f"{path}:") for line in lines), lines
        return [line.removeprefix(f"{path}:") for line in lines]

    return read


def test_a_tree_by_hand_becomes_a_task_that_reads_well(imported, tmp_path):
    text = imported(
        """
    <Sequence name="fetch it">
      <RetryUntilSuccessful num_attempts="{tries}">
        <Timeout msec="1500"><Action ID="navigate" name="go" to="{home}" speed_m_s="0.5"/></Timeout>
      </RetryUntilSuccessful>
      <Fallback><Condition ID="holding_object"/><open_gripper/></Fallback>
      <Script code="count := 3; word := 'two words'"/>
      <say text="{word}"/>
    </Sequence>"""
    )
    assert text == (
        "  name: fetch it\n"
        "  sequence:\n"
        "  - name: go\n"
        "    timeout_s: 1.5\n"
        "    retry: $tries\n"
        "    navigate: {to: home, speed_m_s: 0.5}\n"
        "  - fallback: [holding_object, open_gripper]\n"
        "  - set: {count: 3, word: two words}\n"
        "  - say: {text: $word}\n"
    )
    assert (
        dry_run(tmp_path / "fetch.yaml", outcomes=[], overrides={}, most_ticks=9).outcome.end.value
        == "success"
    )


def test_modifiers_in_another_order_than_ours_keep_their_meaning(imported, tmp_path):
    """An inverted retry is not a retried inversion."""
    text = imported(
        '<Inverter><RetryUntilSuccessful num_attempts="2"><open_gripper/>'
        "</RetryUntilSuccessful></Inverter>"
    )
    assert text == "  invert: true\n  sequence:\n  - retry: 2\n    open_gripper: null\n"
    path = tmp_path / "fetch.yaml"
    run = dry_run(path, outcomes=["open_gripper=failure,success"], overrides={}, most_ticks=9)
    assert run.outcome.end.value == "failure"
    assert [step.status for step in run.steps if step.key == "open_gripper"] == [
        "failure",
        "success",
    ]


def test_every_tree_becomes_a_file_and_subtrees_are_remapped(tmp_path):
    path = tmp_path / "two.xml"
    path.write_text(
        """<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="outer">
  <BehaviorTree ID="outer">
    <Sequence>
      <SubTree ID="look" name="first" seconds="2" found="{count}"/>
      <SubTree ID="look" name="second" seconds="{count}" found="{=}"/>
      <at_least value="{found}" least="1"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="look" _description="Look around.">
    <Sequence>
      <wait duration_s="{seconds}"/>
      <Script code="found := 4"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="look">
      <input_port name="seconds" type="double">how long</input_port>
      <output_port name="found">what was there</output_port>
    </SubTree>
  </TreeNodesModel>
</root>
"""
    )
    texts = import_xml(path)
    assert list(texts) == ["outer.yaml", "look.yaml"]
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert check(tmp_path / "outer.yaml") == []
    assert "out: {found: count}" in texts["outer.yaml"]
    assert "with: {seconds: $count}" in texts["outer.yaml"]
    assert "seconds: {type: float, description: how long}" in texts["look.yaml"]
    run = dry_run(tmp_path / "outer.yaml", outcomes=[], overrides={}, most_ticks=9)
    assert run.outcome.end.value == "success"


# refused, with line and column

REFUSED = {
    "an unknown node": ("<grab/>", "3:5: `grab` has no counterpart; did you mean `grasp`?"),
    "a node of BT.CPP alone": (
        "<KeepRunningUntilFailure><open_gripper/></KeepRunningUntilFailure>",
        "3:5: `KeepRunningUntilFailure` has no counterpart",
    ),
    "Switch": (
        '<Switch2 variable="{tries}" case_1="1" case_2="2"><open_gripper/><open_gripper/>'
        "<open_gripper/></Switch2>",
        "3:5: `Switch2` has no counterpart",
    ),
    "a precondition": (
        '<Sequence>\n<open_gripper _skipIf="tries > 1"/></Sequence>',
        "4:1: `_skipIf` has no counterpart",
    ),
    "a script that computes": (
        '<Script code="n := n + 1"/>',
        "3:5: a script that does more than give values",
    ),
    "a parameter that is none": (
        "<Sequence>\n  <open_gripper/>\n  <open_gripper widely='true'/>\n</Sequence>",
        "5:3: `open_gripper` has no parameter `widely`",
    ),
    "a missing parameter": ("<navigate/>", "3:5: `navigate` lacks `to`"),
    "a value of another type": ('<wait duration_s="long"/>', "3:5: `duration_s`"),
    "a pose that is not there": ('<navigate to="away"/>', "3:5: `to`"),
    "a key that nobody writes": ('<say text="{word}"/>', "3:5: `$word` is neither"),
    "no attempts": (
        '<RetryUntilSuccessful num_attempts="0"><open_gripper/></RetryUntilSuccessful>',
        "3:5: `retry`",
    ),
    "a retry without number": (
        "<RetryUntilSuccessful><open_gripper/></RetryUntilSuccessful>",
        "3:5: `RetryUntilSuccessful` lacks `num_attempts`",
    ),
    "milliseconds from outside": (
        '<Timeout msec="{tries}"><open_gripper/></Timeout>',
        "3:5: `msec`: {tries} is not a whole number",
    ),
    "a node that is skipped": (
        "<RunOnce><open_gripper/></RunOnce>",
        "3:5: `RunOnce` has a counterpart only with `then_skip` false",
    ),
    "a decorator of two": (
        "<Inverter><open_gripper/><open_gripper/></Inverter>",
        "3:5: `Inverter` has 2 children",
    ),
    "a parallel that fails late": (
        '<Parallel success_count="1" failure_count="1"><open_gripper/><arm_healthy/></Parallel>',
        "3:5: success_count 1 with failure_count 1 has no counterpart",
    ),
    "an empty sequence": ("<Sequence/>", "3:5: `sequence` is empty"),
    "a text that would become a reference": (
        "<say text='$tries'/>",
        "3:5: the text '$tries' has no counterpart",
    ),
    "another tree": ('<SubTree ID="away"/>', "3:5: the tree `away` is not in the file"),
    "a tree in itself": ('<SubTree ID="fetch"/>', "3:5: the tree `fetch` goes round in a circle"),
    "an automatic remapping": (
        '<SubTree ID="fetch" _autoremap="true"/>',
        "3:5: `_autoremap` has no counterpart",
    ),
    "two roots": ("<open_gripper/><open_gripper/>", "2:3: the tree `fetch` has 2 roots"),
    "an output to nowhere": (
        '<scan_for_objects region="{home}" count="4"/>',
        "3:5: `count` writes to an entry of the blackboard",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_counterpart_is_refused_where_it_stands(refused, case):
    tree, said = REFUSED[case]
    found = refused(TREE.replace("{}", tree))
    assert any(line.startswith(said) for line in found), found


def test_all_complaints_come_at_once(refused):
    found = refused(TREE.replace("{}", "<Sequence>\n<grab/>\n<Script code='f()'/>\n</Sequence>"))
    assert [line.split(": ")[0] for line in found] == ["4:1", "5:1"]


BOMB = """<?xml version="1.0"?>
<!DOCTYPE bomb [<!ENTITY a "haha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<root BTCPP_format="4"><BehaviorTree ID="x"><say text="&b;"/></BehaviorTree></root>
"""

FILES = {
    "a bomb of entities": (BOMB, "2:16: a document type is not read"),
    "an entity from a file": (
        '<!DOCTYPE x [<!ENTITY f SYSTEM "file:///etc/passwd">]>\n<root>&f;</root>',
        "1:13: a document type is not read",
    ),
    "no XML": ("task: t\n", "1:1: this is not XML"),
    "nothing": ("", "1:1: this is not XML: no element found"),
    "half of it": ('<root BTCPP_format="4">\n  <BehaviorTree', "2:3: this is not XML"),
    "a tag left open": ("<root>\n<a>\n</root>", "3:3: this is not XML: mismatched tag"),
    "another format": ('<root BTCPP_format="3"/>', "1:1: this is not a tree of BehaviorTree.CPP 4"),
    "no tree": ('<root BTCPP_format="4"/>', "1:1: there is no tree"),
    "another file": (
        '<root BTCPP_format="4">\n <include path="../../etc/passwd"/></root>',
        "2:2: `<include>` has no counterpart",
    ),
    "a name that leads away": (
        '<root BTCPP_format="4">\n<BehaviorTree ID="../x"><arm_healthy/></BehaviorTree></root>',
        "2:1: `../x` cannot name a task",
    ),
    "two trees of a name": (
        '<root BTCPP_format="4">\n<BehaviorTree ID="a"><arm_healthy/></BehaviorTree>\n'
        '<BehaviorTree ID="a"><arm_healthy/></BehaviorTree></root>',
        "2:1: there is another tree `a`",
    ),
    "not UTF-8": (b'<root a="\xff"/>', "1:10: byte 0xff is not UTF-8"),
    "much too deep": ("<a>" * 100, "1:193: elements nest deeper than 64 levels"),
}


@pytest.mark.parametrize("case", FILES)
def test_a_file_that_is_no_tree_is_refused(refused, case):
    xml, said = FILES[case]
    found = refused(xml)
    assert any(line.startswith(said) for line in found), found


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(TaskFileError, match="no such file"):
        import_xml(tmp_path / "none.xml")


def test_damaged_files_give_complaints_and_never_a_crash(tmp_path):
    """Characters of a good file changed, dropped and doubled at random."""
    good = export_xml(load(write_everything(tmp_path), open_parameters=True))
    path: Path = tmp_path / "damaged.xml"
    rng = random.Random(7)
    refused = taken = 0
    for _ in range(150):
        text = good
        for _ in range(rng.choice((1, 1, 1, 3))):
            at = rng.randrange(len(text))
            length = rng.choice((1, 1, 5, 20))
            text = (
                text[:at]
                + rng.choice(("", "7", "x", "{", '"', "<", text[at : at + 9]))
                + text[at + length :]
            )
        path.write_text(text, encoding="utf-8")
        try:
            import_xml(path)
        except TaskFileError as error:
            refused += all(diagnostic.path == path for diagnostic in error.diagnostics)
        else:
            taken += 1
    assert refused + taken == 150
    assert refused > 75
