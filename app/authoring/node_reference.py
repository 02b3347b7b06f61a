"""Node reference of `frankie-task nodes`: leaves, composites and modifiers of the task language."""

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from config import UserError, suggest, written
from trees.language import (
    COMPOSITES,
    MODIFIERS,
    NAME,
    SUBTREE,
    LeafType,
    Parameter,
    ValueType,
    describe_leaves,
    known_leaves,
)

_LANGUAGE = {
    NAME: "The node's name in pictures, messages and summaries; stands beside any node.",
    SUBTREE: "Runs the tree of another file: `subtree: {file: ..., with: {...}, out: {...}}`.",
}


def show_all(console: Console) -> None:
    """Print a table of all words, a line each."""
    leaves = describe_leaves(known_leaves())
    conditions = {key: leaf for key, leaf in leaves.items() if leaf.is_condition}
    actions = {key: leaf for key, leaf in leaves.items() if not leaf.is_condition}
    for title, group in (("actions", actions), ("conditions", conditions)):
        rows = ((key, _signature(leaf), leaf.description) for key, leaf in sorted(group.items()))
        console.print(_table(title, rows, ("", "parameters", "what it does")))
    composites = ((key, word.children, word.description) for key, word in COMPOSITES.items())
    others = ((SUBTREE, "a task file", _LANGUAGE[SUBTREE]),)
    console.print(_table("composites", (*composites, *others), ("", "takes", "what it does")))
    modifiers = ((key, _accepted(word.type), word.description) for key, word in MODIFIERS.items())
    named = ((NAME, "text", _LANGUAGE[NAME]),)
    title = "modifiers, innermost first"
    console.print(_table(title, (*named, *modifiers), ("", "takes", "what it does")))
    console.print("frankie-task nodes NAME shows one of them in full.", highlight=False)


def show_one(name: str, console: Console) -> None:
    """Print everything about one word; raises UserError if there is no such word."""
    leaves = describe_leaves(known_leaves())
    if name in leaves:
        _show_leaf(leaves[name], console)
        return
    texts = dict(_LANGUAGE)
    for key, word in COMPOSITES.items():
        texts[key] = f"{word.description}\nTakes {word.children}."
    for key, modifier in MODIFIERS.items():
        takes = _accepted(modifier.type)
        texts[key] = f"{modifier.description}\nTakes {takes}; stands beside a node."
    if name not in texts:
        hint = suggest(name, {*leaves, *texts})
        raise UserError(f"no node is called `{name}`; {hint} `frankie-task nodes` lists all")
    console.print(Text(name, style="bold"))
    console.print(Text(texts[name]), soft_wrap=True)
    if name in COMPOSITES and COMPOSITES[name].options:
        rows = (
            (key, str(option.type), written(option.default), option.description)
            for key, option in COMPOSITES[name].options.items()
        )
        console.print(_table("options", rows, ("", "type", "default", "meaning")))


def _show_leaf(leaf: LeafType, console: Console) -> None:
    console.print(Text(leaf.key, style="bold"), "(condition)" if leaf.is_condition else "")
    console.print(Text(leaf.description), soft_wrap=True)
    if leaf.details:
        console.print(Text(leaf.details), soft_wrap=True)
    if leaf.parameters:
        rows = (
            (one.name, str(one.type), one.unit, _default(one), one.description)
            for one in leaf.parameters.values()
        )
        heads = ("", "type", "unit", "default", "meaning")
        console.print(_table("parameters", rows, heads))
    if leaf.outputs:
        keys = (
            (one.name, str(one.type), one.unit, one.description) for one in leaf.outputs.values()
        )
        title = "outputs: name the key to write to"
        console.print(_table(title, keys, ("", "type", "unit", "meaning")))


def _table(title: str, rows: Iterable[tuple[str, ...]], heads: tuple[str, ...]) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for position, head in enumerate(heads):
        table.add_column(head, no_wrap=position == 0, style="cyan" if position == 0 else "")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    return table


def _signature(leaf: LeafType) -> str:
    """Parameters in short: optional ones in brackets, outputs after an arrow."""
    if leaf.names_keys:
        return "key: value, ..."
    given = [one.name if one.required else f"[{one.name}]" for one in leaf.parameters.values()]
    outputs = [one.name if one.required else f"[{one.name}]" for one in leaf.outputs.values()]
    arrow = f" → {', '.join(outputs)}" if outputs else ""
    return f"{', '.join(given)}{arrow}".strip()


def _accepted(expected: ValueType | None) -> str:
    return "a condition" if expected is None else str(expected)


def _default(parameter: Parameter) -> str:
    if parameter.required:
        return "required"
    default = parameter.default
    plain = default is None or isinstance(default, bool | int | float | str)
    return written(default) if plain else str(default)  # type: ignore[arg-type]
