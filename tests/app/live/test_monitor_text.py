from monitor_samples import FAILURE, IDLE, RUNNING, SUCCESS, TREE

from app.live.monitor.glyphs import safe
from app.live.monitor.snapshot import NodeInfo, NodeStatus, branch, parents, tip


def nodes(*statuses: object) -> list[NodeStatus]:
    return [NodeStatus(status=status, message="") for status in statuses]


def test_safe_text_is_one_line_that_the_font_has() -> None:
    assert safe("Grüße → 90 %, ω ≤ 2 rad/s ✔") == "Grüße → 90 %, ω ≤ 2 rad/s ✔"
    assert safe("two\nlines\t and\x07 a 🤖 ⏱ ✖") == "two lines and□ a □ □ □"
    assert safe("") == ""


def test_parents_and_branch_follow_depth() -> None:
    assert parents(TREE) == (None, 0, 1, 1, 3, 3, 5, 6, 6, 6, 3, 3)
    assert branch(TREE, 9) == (0, 1, 3, 5, 6, 9)
    assert branch(TREE, 0) == (0,)
    assert parents([NodeInfo(name="a", kind="wait", depth=0)]) == (None,)


def test_the_tip_is_where_the_root_got_its_status_from() -> None:
    assert tip(nodes(RUNNING, SUCCESS, RUNNING, IDLE)) == 2
    assert tip(nodes(FAILURE, SUCCESS, FAILURE, FAILURE, IDLE)) == 3
    assert tip(nodes(SUCCESS, FAILURE, SUCCESS)) == 2
    assert tip(nodes(RUNNING, FAILURE, IDLE)) == 0
    assert tip(nodes(IDLE, IDLE, IDLE)) == 0
