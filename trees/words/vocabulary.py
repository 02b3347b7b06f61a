"""The words of the language: composites, modifiers and the other keys."""

from collections.abc import Mapping

from trees.words import composites, data_nodes, modifiers

CHILDREN = "children"  # the key of the children where a composite has options
NAME = "name"  # the key that names a node
SUBTREE = "subtree"  # the key of a node that stands for the tree of another file

COMPOSITES: Mapping[str, type[composites.CompositeWord]] = {
    word.key: word
    for word in (
        composites.Sequence,
        composites.Fallback,
        composites.Parallel,
        composites.Forever,
        composites.Until,
        composites.Not,
        data_nodes.ForEach,
        data_nodes.Switch,
    )
}

ASKING: Mapping[str, type[composites.CompositeWord]] = {
    word.key: word for word in (composites.AllOf, composites.AnyOf)
}
"""What composites are that have conditions alone: conditions of these."""

MODIFIERS: Mapping[str, type[modifiers.ModifierWord]] = {
    word.word or word.key: word
    for word in (
        modifiers.Timeout,
        modifiers.Retry,
        modifiers.Repeat,
        modifiers.Unless,
        modifiers.While,
        modifiers.Force,
    )
}
"""Innermost first: this order holds whatever the order in the file."""

RESERVED = frozenset({NAME, SUBTREE, *COMPOSITES, *MODIFIERS})  # no leaf may have these
