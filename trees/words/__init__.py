"""The words of the language: the nodes that they are built into, their rules and their types."""

from trees.words.branch import (
    Branch,
    Counterpart,
    Need,
    Ticking,
    TreeNode,
    failed_node,
    intent_of,
    is_answer,
    nodes_in_order,
    ticked,
)
from trees.words.composites import CompositeWord, Form
from trees.words.data_nodes import Add, ForEachOf, LateLeaf, Set, Subtree, Supply, is_case
from trees.words.modifiers import ModifierWord
from trees.words.outcomes import (
    EMPTY,
    FULL,
    HAND,
    JUST,
    UNUSED_HAND,
    Keys,
    Outcome,
    Outcomes,
    all_in_order,
    either,
    first_success,
    rounds,
    without_hand,
)
from trees.words.value_types import (
    NAMED_TYPES,
    PARAMETER_TYPES,
    SEEN_LIST,
    SEEN_ONE,
    SEEN_TYPES,
    NamedValue,
    ValueType,
    read_annotation,
    type_of,
)
from trees.words.vocabulary import (
    ASKING,
    CHILDREN,
    COMPOSITES,
    MODIFIERS,
    NAME,
    RESERVED,
    SUBTREE,
)
