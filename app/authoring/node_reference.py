"""The words of the task language as lines of text: for `frankie-task nodes`, and for a model."""

from collections.abc import Iterator

from config import UserError, suggest
from trees.language import (
    COMPOSITES,
    MODIFIERS,
    NAME,
    SUBTREE,
    LeafType,
    Output,
    Parameter,
    describe_leaves,
    known_leaves,
)

_SUBTREE = "the tree of another file: `subtree: {file: ..., with: {...}, out: {...}}`"
_NAME = "text; the name of the node in pictures, messages and summaries"


def all_words(*, about: bool, parameters: bool) -> Iterator[str]:
    """A line for each word, perhaps with what it is about, and for each parameter of a leaf."""
    yield "# Composites: a node with one of these keys has children"
    for key, word in COMPOSITES.items():
        yield f"{key}: {word.takes}{f'; {word.description}' * about}"
    yield f"{SUBTREE}: {_SUBTREE}"
    yield "# Modifiers, innermost first: keys beside the key of a node"
    yield f"{NAME}: {_NAME}"
    for key, modifier in MODIFIERS.items():
        yield f"{key}: {modifier.type or 'a condition'}{f'; {modifier.description}' * about}"
    leaves = sorted(describe_leaves(known_leaves()).values(), key=lambda leaf: leaf.key)
    for title, asks in (("Conditions", True), ("Behaviours", False)):
        yield f"# {title}, and their parameters; those in brackets may be left out"
        for leaf in leaves:
            if leaf.is_condition is asks:
                lines = _leaf(leaf)
                yield from lines if parameters else [next(lines)]


def one_word(name: str) -> Iterator[str]:
    """Everything about one word; raises UserError if there is no such word."""
    leaves = describe_leaves(known_leaves())
    if name in leaves:
        first, *parameters = _leaf(leaves[name])
        yield from filter(None, (first, leaves[name].details, *parameters))
    elif name in COMPOSITES:
        word = COMPOSITES[name]
        yield f"{name}: {word.takes}\n{word.description}"
        for key, option in word.options.items():
            yield f"  {key}: {option.type} ({option.default}): {option.description}"
    elif name in MODIFIERS:
        modifier = MODIFIERS[name]
        yield f"{name}: {modifier.type or 'a condition'}, beside a node\n{modifier.description}"
    elif name in (SUBTREE, NAME):
        yield f"{name}: {_SUBTREE if name == SUBTREE else f'{_NAME}; beside a node'}"
    else:
        hint = suggest(name, {*leaves, *COMPOSITES, *MODIFIERS, SUBTREE, NAME})
        raise UserError(f"no node is called `{name}`; {hint} `frankie-task nodes` lists all")


def _leaf(leaf: LeafType) -> Iterator[str]:
    names = (one.name if one.required else f"[{one.name}]" for one in leaf.described)
    yield f"{leaf.key}{': ' * bool(leaf.described)}{', '.join(names)}; {leaf.description}"
    yield from (f"  {_parameter(one)}" for one in leaf.described)


def _parameter(one: Parameter) -> str:
    if isinstance(one, Output):
        return f"{one.name}: a key that takes {one.type}: {one.description}"
    default = "" if one.required or one.default is None else f" ({one.default})"
    return f"{one.name}: {one.type}{default}: {one.description}"
