"""The tree language: task files in YAML, checked completely, built into py_trees behaviours.

`load` reads a file into a `Task` or raises every diagnostic in it at once, each with its location
and a hint; `build` makes the tree. Leaves are classes with typed constructors (see `leaf_classes`),
the other words of the language are in `trees.words`.
"""

from trees.language.builder import build, real_leaf
from trees.language.documents import FILE_KEYS, ParameterSection, TaskParameter
from trees.language.leaf_classes import describe_leaves
from trees.language.leaf_type import ADD, SET, LeafError, LeafType, Output, Parameter
from trees.language.loader import examine, load
from trees.language.mappings import NAMING_HINT, WORD
from trees.language.named_poses import PoseSection, RegionSection
from trees.language.registry import known_leaves, plugin_problems
from trees.language.rules import LANGUAGE_RULES, NO_COUNTERPART
from trees.language.syntax import (
    SCENE,
    CompositeNode,
    LeafNode,
    Node,
    SubtreeNode,
    Task,
    TaskFileError,
    leaves_at,
    nodes_below,
)
from trees.language.values import Argument, KeyRead, KeyWrite
from trees.words import (
    ASKING,
    CHILDREN,
    COMPOSITES,
    MODIFIERS,
    NAME,
    PARAMETER_TYPES,
    SUBTREE,
    Branch,
    CompositeWord,
    Counterpart,
    Form,
    ModifierWord,
    NamedValue,
    Ticking,
    TreeNode,
    ValueType,
    failed_node,
    intent_of,
    is_answer,
    nodes_in_order,
    ticked,
)
