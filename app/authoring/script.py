"""Scripted outcomes and keys of a dry run."""

from collections.abc import Iterator, Mapping, Sequence

from py_trees.common import Status

from config import Plain, UserError, parse_scalar, quoted, suggest
from trees.language import LeafNode, SubtreeNode, Task, leaves_at, nodes_below

OUTCOMES: Mapping[str, Status] = {
    "success": Status.SUCCESS,
    "failure": Status.FAILURE,
    "running": Status.RUNNING,
}


class Script:
    """The outcomes of leaves.

    `outcomes` are by node name or leaf key, in turn; the last repeats. Names take precedence, and
    nodes of the same word share a list.
    """

    def __init__(self, outcomes: Mapping[str, Sequence[Status]]) -> None:
        self._outcomes = outcomes
        self._taken = dict.fromkeys(outcomes, 0)

    def tells(self, name: str, key: str) -> bool:
        """Whether it contains a leaf."""
        return name in self._outcomes or key in self._outcomes

    def next(self, name: str, key: str) -> tuple[Status, str]:
        """The outcome of the next tick of a leaf, and its reason."""
        word = name if name in self._outcomes else key
        if word not in self._outcomes:
            return Status.SUCCESS, "not scripted"
        statuses, number = self._outcomes[word], self._taken[word] + 1
        self._taken[word] = number
        again = ", again" if number > len(statuses) else ""
        number = min(number, len(statuses))
        return statuses[number - 1], f"scripted, {number} of {len(statuses)}{again}"


def read_script(texts: Sequence[str], task: Task) -> Script:
    """The script in texts such as `grasp=failure,failure,success`.

    Raises UserError: it is invalid, or the tree has no such leaf.
    """
    words = sorted({word for leaf in _leaves(task) for word in (leaf.name, leaf.type.key)})
    outcomes = {}
    for text in texts:
        word, equals, listed = text.rpartition("=")
        if not equals or not word:
            example = "for example --outcome grasp=failure,success"
            raise UserError(f"--outcome {text}: write a node and its outcomes, {example}")
        if word not in words:
            hint = f"{suggest(word, words)} The tree has {quoted(words)}"
            raise UserError(f"--outcome {text}: the tree has no leaf `{word}`; {hint}")
        outcomes[word] = [_outcome(one.strip(), text) for one in listed.split(",")]
    return Script(outcomes)


def _outcome(word: str, text: str) -> Status:
    if word not in OUTCOMES:
        known = ", ".join(f"`{known}`" for known in OUTCOMES)
        raise UserError(f"--outcome {text}: `{word}` is not an outcome; write {known}")
    return OUTCOMES[word]


def _leaves(task: Task) -> Iterator[LeafNode]:
    """The leaves of a task that can be scripted, with guards and subtrees, without `set`."""
    for node in nodes_below(task.root):
        yield from (leaf for leaf in leaves_at(node) if not leaf.type.names_keys)
        if isinstance(node, SubtreeNode):
            yield from _leaves(node.task)


def read_keys(texts: Sequence[str], task: Task) -> dict[str, Plain]:
    """Values of keys, from texts such as `found=3`.

    Raises UserError: it is invalid, or no leaf of the tree writes such a key.
    """
    written = sorted({key.name for leaf in _leaves(task) for key in leaf.outputs.values()})
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise UserError(f"--key {text}: write a key and its value, for example --key found=3")
        if name not in written:
            raise UserError(f"--key {text}: no leaf writes `{name}`; {suggest(name, written)}")
        values[name] = parse_scalar(value)
    return values
