"""Why a tree runs a node, and what it does next: by the ancestors of the node."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from app.live import NodeInfo, NodeStatus, parents, path_from_root

_SEQUENCES = ("sequence", "for_each")
_FALLBACKS = ("fallback", "switch")
_AGAIN = ("retry", "forever", "repeat")
_ATTEMPT = re.compile(r"attempt \d+ of \d+")


class Step(NamedTuple):
    """What comes next."""

    title: str
    does: str = ""  # what a leaf does, in a sentence


_ENDS = {True: Step("the task succeeds"), False: Step("the task fails")}


def purpose(tree: Sequence[NodeInfo], nodes: Sequence[NodeStatus], index: int) -> list[str]:
    """What a node is done for, from the root down: ancestors with a name, and their attempts."""
    found = []
    for above in path_from_root(tree, index)[:-1]:
        if tree[above].name != tree[above].kind:
            found.append(_title(tree, above))
        if tree[above].kind == "retry" and (tried := _ATTEMPT.match(nodes[above].message)):
            found.append(tried[0])
    return found


def outlook(tree: Sequence[NodeInfo], index: int) -> tuple[Step, Step]:
    """What comes after a success of a node and after its failure.

    Limits on attempts and times are left out. Between two attempts it is the next attempt.
    """
    above = parents(tree)
    if tree[index].kind in _AGAIN and index in above:
        again = _again(tree, above, index)
        return again, again
    return _after(tree, above, index, True), _after(tree, above, index, False)


def _after(
    tree: Sequence[NodeInfo], above: Sequence[int | None], index: int, success: bool
) -> Step:
    parent = above[index]
    if parent is None:
        return _ENDS[success]
    kind = tree[parent].kind
    children = [child for child, one in enumerate(above) if one == parent]
    later = children[children.index(index) + 1 :]
    first = index == children[0]
    match kind:
        case kind if (kind in _SEQUENCES and success) or (kind in _FALLBACKS and not success):
            if later and kind != "switch":
                return _entered(tree, above, later[0])
        case "until" if not success and first and later:
            return _entered(tree, above, later[0])
        case "until" if success and not first:
            return _entered(tree, above, later[0] if later else children[0])
        case kind if kind in _AGAIN and success is (kind == "repeat"):
            return _again(tree, above, index)
        case "parallel":
            return Step(f"the rest of {tree[parent].name}")
        case "not":
            success = not success
        case "force_success" | "force_failure":
            success = kind == "force_success"
    return _after(tree, above, parent, success)


def _again(tree: Sequence[NodeInfo], above: Sequence[int | None], index: int) -> Step:
    step = _entered(tree, above, index)
    return step._replace(title=f"{step.title} again")


def _entered(tree: Sequence[NodeInfo], above: Sequence[int | None], index: int) -> Step:
    """The first node below that its author has named or that does something."""
    while tree[index].name == tree[index].kind and (inner := index + 1) in range(len(tree)):
        if above[inner] != index:
            break
        index = inner
    return Step(_title(tree, index), tree[index].does)


def _title(tree: Sequence[NodeInfo], index: int) -> str:
    """The title of a node; that of the question of an `until` ends in a question mark."""
    asks = index > 0 and tree[index - 1].kind == "until"
    return f"{tree[index].title.removesuffix('?')}?" if asks else tree[index].title
