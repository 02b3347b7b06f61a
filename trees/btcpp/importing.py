"""XML of BehaviorTree.CPP 4 as task files: the part of it that the language has too.

What the language does not have (scripts that compute, `_skipIf` and its like, `Switch`, trees in
other files) is refused at its line and column. Each tree of the XML becomes a file; what the
language finds wrong in one is reported where it stands in the XML.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from config import suggest
from trees.btcpp.elements import Element, read_elements
from trees.btcpp.nodes import Nodes
from trees.btcpp.ports import pointed_at
from trees.btcpp.sections import Located, Sections, read_sections
from trees.btcpp.words import MAIN, SUBTREE
from trees.btcpp.writing import traced, yaml_text
from trees.language import TaskFileError, load
from trees.language.diagnostics import Diagnostics
from trees.language.registry import LeafType, describe_leaves, known_leaves
from trees.language.source import read_text
from trees.language.tables import WORD


def import_xml(path: Path) -> dict[str, str]:
    """The task files that an XML file amounts to.

    Args:
        path: the XML file.

    Returns:
        Texts by file name, that of the main tree first.

    Raises:
        TaskFileError: with every part that has no counterpart, or if it is not XML.
        LeafError: a leaf class, not the file, is at fault.
    """
    diagnostics = Diagnostics(path)
    text = read_text(path, diagnostics)
    root = None if text is None else read_elements(text, diagnostics)
    files = {} if root is None else _files(root, describe_leaves(known_leaves()), diagnostics)
    if diagnostics.fatal:
        raise TaskFileError(diagnostics.in_order())
    texts = {name: yaml_text(said) for name, said in files.items()}
    _check(texts, files, path)
    return texts


def _check(texts: Mapping[str, str], files: Mapping[str, Located], path: Path) -> None:
    """Let the language check the files; what it finds is told with the place in the XML."""
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        try:
            load(Path(folder) / next(iter(texts)), open_parameters=True)
        except TaskFileError as error:
            raise TaskFileError(
                replace(
                    diagnostic,
                    path=path,
                    place=traced(
                        diagnostic.place, texts[diagnostic.path.name], files[diagnostic.path.name]
                    ),
                )
                for diagnostic in error.diagnostics
            ) from None


def _files(
    root: Element, leaves: Mapping[str, LeafType], diagnostics: Diagnostics
) -> dict[str, Located]:
    """What each task file says, by its name, that of the main tree first."""
    if root.tag != "root" or root.attributes.get("BTCPP_format") != "4":
        what = "this is not a tree of BehaviorTree.CPP 4"
        diagnostics.error(root.place, what, 'the root is `<root BTCPP_format="4">`')
        return {}
    for child in root.children:
        if child.tag not in ("BehaviorTree", "TreeNodesModel"):
            what = f"`<{child.tag}>` has no counterpart"
            diagnostics.error(child.place, what, "put all trees into one file, without others")
    trees = {tree.attributes.get("ID", ""): tree for tree in root.all("BehaviorTree")}
    for tree in root.all("BehaviorTree"):
        name = tree.attributes.get("ID", "")
        if trees[name] is not tree:
            diagnostics.error(tree.place, f"there is another tree `{name}`", "rename one of them")
    models = {
        model.attributes.get("ID", ""): read_sections(model, diagnostics)
        for all_models in root.all("TreeNodesModel")
        for model in all_models.all(SUBTREE)
    }
    main = root.attributes.get("main_tree_to_execute", next(iter(trees), ""))
    if main not in trees:
        what = f"there is no tree `{main}`"
        diagnostics.error(root.place, what, suggest(main, trees))
        return {}
    found = _Trees(trees=trees, models=models, leaves=leaves, diagnostics=diagnostics)
    found.add(_unwrapped(main, trees))
    return dict(reversed(found.files.items()))


def _unwrapped(main: str, trees: Mapping[str, Element]) -> str:
    """The tree that the main tree only passes its own entries to, else the main tree itself."""
    children = trees[main].children
    if main != MAIN or len(children) != 1 or children[0].tag != SUBTREE:
        return main
    ports = {key: text for key, text in children[0].attributes.items() if key != "ID"}
    inner = children[0].attributes.get("ID", "")
    passes_on = all(pointed_at(text) == key for key, text in ports.items())
    return inner if passes_on and inner in trees else main


@dataclass(frozen=True, kw_only=True, eq=False)
class _Trees:
    """Turns the trees that the main tree needs into files, inner ones first."""

    trees: Mapping[str, Element]
    models: Mapping[str, Sections]
    leaves: Mapping[str, LeafType]
    diagnostics: Diagnostics
    files: dict[str, Located] = field(default_factory=dict)
    under_way: list[str] = field(default_factory=list)

    def add(self, name: str) -> None:
        """Add the file of a tree, and those of the trees that it needs."""
        tree = self.trees[name]
        if not WORD.fullmatch(name):
            hint = "use letters, digits and `_`, and begin with a letter"
            self.diagnostics.error(tree.place, f"`{name}` cannot name a task", hint)
            return
        if len(tree.children) != 1:
            what = f"the tree `{name}` has {len(tree.children)} roots"
            self.diagnostics.error(tree.place, what, "give it one")
            return
        self.under_way.append(name)
        sections = self.models.get(name, Sections())
        nodes = Nodes(
            sections=sections,
            leaves=self.leaves,
            diagnostics=self.diagnostics,
            include=self.include,
        )
        said = {
            "task": name,
            "description": tree.attributes.get("_description"),
            "scene": tree.attributes.get("_scene"),
            "params": sections.params,
            "outputs": sections.outputs,
            "poses": sections.poses,
            "regions": sections.regions,
            "tree": nodes.node(tree.children[0]),
        }
        self.under_way.pop()
        self.files[f"{name}.yaml"] = Located(
            tree.place, {key: value for key, value in said.items() if value}
        )

    def include(self, name: str, element: Element) -> Sections | None:
        """Add the tree that a node stands for; returns its ports, or None and a diagnostic."""
        if name not in self.trees or name in self.under_way:
            around = "goes round in a circle" if name in self.trees else "is not in the file"
            known = [tree for tree in self.trees if tree not in self.under_way]
            what = f"the tree `{name}` {around}"
            self.diagnostics.error(element.place, what, suggest(name, known))
            return None
        if f"{name}.yaml" not in self.files:
            self.add(name)
        return self.models.get(name, Sections())
