from sample_run import FAILURE, IDLE, RUNNING, SUCCESS, TREE

from app.live.monitor.glyphs import printable
from app.live.nodes import NodeInfo, NodeStatus, parents, path_from_root, tip


def nodes(*statuses: object) -> list[NodeStatus]:
    return [NodeStatus(status=status, message="") for status in statuses]


def test_safe_text_is_one_line_that_the_font_has() -> None:
    assert printable("Grüße → 90 %, ω ≤ 2 rad/s ✔") == "Grüße → 90 %, ω ≤ 2 rad/s ✔"
    assert printable("two\nlines\t and\x07 a 🤖 ⏱ ✖") == "two lines and□ a □ □ □"
    assert printable("") == ""


def test_parents_and_branch_follow_depth() -> None:
    assert parents(TREE) == (None, 0, 1, 1, 3, 3, 5, 6, 6, 6, 3, 3)
    assert path_from_root(TREE, 9) == (0, 1, 3, 5, 6, 9)
    assert path_from_root(TREE, 0) == (0,)
    assert parents([NodeInfo(name="a", kind="wait", depth=0)]) == (None,)


def test_the_tip_is_where_the_root_got_its_status_from() -> None:
    assert tip(nodes(RUNNING, SUCCESS, RUNNING, IDLE)) == 2
    assert tip(nodes(FAILURE, SUCCESS, FAILURE, FAILURE, IDLE)) == 3
    assert tip(nodes(SUCCESS, FAILURE, SUCCESS)) == 2
    assert tip(nodes(RUNNING, FAILURE, IDLE)) == 0
    assert tip(nodes(IDLE, IDLE, IDLE)) == 0
