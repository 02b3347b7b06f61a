"""A task as XML for BehaviorTree.CPP 4, which Groot2 opens.

Each task file becomes a tree of the XML, in one text or in a file of its own, with its parameters,
poses and regions as ports. The tree `Main` runs the task with their defaults. The models of nodes
that BehaviorTree.CPP lacks stand at the end.
"""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from config import Diagnostics, Location
from extensions.export.btcpp.counterparts import MAIN, SUBTREE, pointer
from extensions.export.btcpp.xml_writer import Export
from trees.language import NO_COUNTERPART, Task, TaskFileError


def export_xml(task: Task) -> str:
    """The XML of a task and of the files that it includes, in one text.

    The task is loaded with open parameters, so that `$name` is still there. Raises TaskFileError:
    something in it has no counterpart in the XML.
    """
    export = Export(task)
    root = _root(_main(task))
    root.extend(export.trees.values())
    return _text(root, export.models, export.models)


def export_files(task: Task) -> dict[Path, str]:
    """The XML of a task, and a file of XML for each file that it includes.

    Each includes those that it uses, so that each can be opened alone; that of the task comes
    first. Raises TaskFileError: something in it has no counterpart in the XML.
    """
    export = Export(task)
    home = task.path.resolve().parent
    texts: dict[Path, str] = {}
    for path, tree in export.trees.items():
        root = _root(*((_main(task),) if path == task.path else ()))
        for number, other in enumerate(sorted(export.included[path])):
            include = Element("include", path=_beside(other, path.resolve().parent).as_posix())
            root.insert(number, include)
        root.append(tree)
        place = _beside(path, home)
        if place in texts:
            diagnostics = Diagnostics(path)
            message = f"another file of the task becomes `{place}` too"
            diagnostics.error(
                NO_COUNTERPART, Location(line=1, column=1), message, "rename one of them"
            )
            raise TaskFileError(diagnostics.in_order())
        texts[place] = _text(root, export.models, export.used[path])
    return texts


def _beside(path: Path, folder: Path) -> Path:
    """The XML of a task file, relative to a folder."""
    return Path(os.path.relpath(path.resolve(), folder)).with_suffix(".xml")


def _main(task: Task) -> Element:
    """The tree that runs the task with its defaults."""
    required = [name for name, one in task.parameters.items() if one.default is None]
    main = Element("BehaviorTree", ID=MAIN)
    SubElement(main, SUBTREE, {"ID": task.name} | {name: pointer(name) for name in required})
    return main


def _root(*trees: Element) -> Element:
    root = Element("root", BTCPP_format="4")
    if trees:
        root.set("main_tree_to_execute", MAIN)
    root.extend(trees)
    return root


def _text(root: Element, models: Mapping[str, Element], used: Iterable[str]) -> str:
    SubElement(root, "TreeNodesModel").extend(models[key] for key in sorted(used))
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"
