"""The words of the language: the nodes that they are built into, their rules and their types."""

from trees.words.branch import (
    Branch,
    Ticking,
    TreeNode,
    failed_node,
    is_answer,
    nodes_in_order,
    ticked,
)
from trees.words.data_nodes import Add, ForEachOf, LateLeaf, Set, Subtree, Supply, is_case
from trees.words.value_types import (
    NAMED_TYPES,
    PARAMETER_TYPES,
    SEEN_LIST,
    SEEN_ONE,
    SEEN_TYPES,
    TYPES_BY_NAME,
    NamedValue,
    ValueType,
    read_annotation,
    type_of,
)
from trees.words.vocabulary import CHILDREN, COMPOSITES, MODIFIERS, NAME, RESERVED, SUBTREE
from trees.words.words import (
    EMPTY,
    FULL,
    HAND,
    JUST,
    UNUSED_HAND,
    CompositeWord,
    Counterpart,
    Form,
    InOrder,
    Keys,
    ModifierWord,
    Need,
    Outcome,
    Outcomes,
    either,
    rounds,
    without_hand,
)
