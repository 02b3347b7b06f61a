"""README and docs: every command line parses, every link and every file name leads somewhere."""

from __future__ import annotations

import ast
import importlib
import re
import shlex
from pathlib import Path

import pytest
from typer.main import get_group

from app.commands import app
from extensions.faults import INJECTABLE
from hw.sim import scene_names
from trees import find

ROOT = Path(__file__).parents[1]
PAGES = [
    page
    for folder in ("", "docs/", "perception/weights/")
    for page in sorted(ROOT.glob(f"{folder}*.md"))
    if page.name != "CHANGELOG.md"
]
COMMANDS = get_group(app)
CODE = re.compile(r"^```\w*\n(.*?)^```$|`([^`\n]+)`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
FILE = re.compile(r"[a-z_]+/[\w/.-]*")
TOPS = {path.name for path in ROOT.iterdir() if path.is_dir()}

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def pieces(page: Path) -> list[str]:
    """The lines of the code blocks of a page, and its inline code."""
    found = []
    for block, inline in CODE.findall(page.read_text(encoding="utf-8")):
        found += block.splitlines() if block else [inline]
    return [piece.removeprefix("$ ").removeprefix(".venv/bin/") for piece in found]


def command_lines(page: Path, program: str) -> list[list[str]]:
    """The arguments of each call of a program, without what a shell does with its output."""
    lines = []
    for piece in pieces(page):
        if piece.startswith(f"{program} "):
            words = shlex.split(piece, comments=True)
            end = next((at for at, word in enumerate(words) if word in ("|", ">", "&&")), None)
            lines.append(words[1:end])
    return lines


def parse(words: list[str]) -> tuple[str, dict[str, object]]:
    """The command that a line calls, and its parameters; a mistake raises typer's usage error.

    A line without arguments may be the mention of a command that requires some.
    """
    command, context, rest = COMMANDS, None, words
    path = ["frankie-task"]
    while hasattr(command, "commands") and rest:
        context = command.context_class(command, info_name=path[-1], parent=context)
        name, command, rest = command.resolve_command(context, rest)
        path.append(name)
    context = command.make_context(path[-1], rest, parent=context, resilient_parsing=not rest)
    return " ".join(path[1:]), context.params


def is_left_to_the_reader(word: str) -> bool:
    """A file that the reader has, as `ours.yaml`, or a word in capitals, as `RUN`."""
    return word.isupper() or word.endswith(".yaml")


@each_page
def test_every_command_line_parses(page):
    for words in command_lines(page, "frankie-task"):
        command, given = parse(words)
        task = given.get("tree")
        for name in given.get("trees") or ([task] if isinstance(task, str) else []):
            assert is_left_to_the_reader(name) or find(name).is_file() or (ROOT / name).is_file()
        if isinstance(scene := given.get("scene"), str):
            assert is_left_to_the_reader(scene) or scene in scene_names()
        if isinstance(robot := given.get("robot"), str):
            names = {"both", *(file.stem for file in (ROOT / "robots").glob("*.yaml"))}
            assert is_left_to_the_reader(robot) or robot in names
        if command == "run":
            for watcher in given["observers"] or []:
                if (name := watcher.partition(":"))[0] == "faults":
                    faults = [one.strip().partition("@")[0] for one in name[2].split(",")]
                    assert {*faults} <= {*INJECTABLE}
        if command == "nodes" and given["name"]:
            assert is_left_to_the_reader(given["name"]) or given["name"] in ("grasp", "wave")


def options(command) -> set[str]:
    """The options of a command and of those below it."""
    own = {name for parameter in command.params for name in parameter.opts}
    if not hasattr(command, "list_commands"):
        return own
    below = (command.get_command(None, name) for name in command.list_commands(None))
    return own.union(*map(options, below))


@each_page
def test_every_option_that_is_named_alone_exists(page):
    known = options(COMMANDS) | {"--help"}
    named = [piece.split()[0] for piece in pieces(page) if piece.startswith("--")]
    assert [name for name in named if name not in known] == []


def test_a_command_line_that_is_wrong_would_be_noticed():
    for line in ("run pick_place --sead 3", "rum", "bench reach --count x", "explain --as"):
        with pytest.raises(Exception, match=r"No such|valid integer|requires an argument"):
            parse(line.split())


@each_page
def test_every_other_command_names_what_is_there(page):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    for words in command_lines(page, "make"):
        assert [word for word in words if "=" not in word and word not in targets] == []
    for words in command_lines(page, "pytest"):
        for word in words:
            assert not word.startswith("tests/") or (ROOT / word).exists(), word
    for _, module in (words[:2] for words in command_lines(page, "python")):
        assert (ROOT / module.replace(".", "/")).with_suffix(".py").is_file(), module


@each_page
def test_python_examples_import_names_that_exist(page):
    for block in re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.M | re.S):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and node.module == "greeting":
                continue  # the guide's own file
            if isinstance(node, ast.ImportFrom) and node.module:
                module = importlib.import_module(node.module)
                assert [name.name for name in node.names if not hasattr(module, name.name)] == []


@each_page
def test_every_file_that_is_named_is_there(page):
    named = [
        piece
        for _, piece in CODE.findall(page.read_text(encoding="utf-8"))
        if FILE.fullmatch(piece) and piece.partition("/")[0] in TOPS
    ]
    assert [name for name in named if not (ROOT / name).exists()] == []


def anchors(page: Path) -> set[str]:
    """The anchors of the headings of a page, as GitHub makes them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@each_page
def test_every_link_leads_to_a_page_and_its_heading(page):
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if link.startswith(("http:", "https:")):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_every_page_that_the_code_names_is_there():
    missing = []
    for top in sorted(TOPS - {"docs", "OUT"}):
        if top.startswith("."):
            continue
        for file in (ROOT / top).rglob("*"):
            if file.suffix in (".py", ".yaml", ".html", ".js"):
                text = file.read_text(encoding="utf-8")
                pages = re.findall(r"\bdocs/[a-z_]+\.(?:md|yaml)", text)
                missing += [f"{file}: {page}" for page in pages if not (ROOT / page).is_file()]
    assert missing == []


def test_every_page_is_found_from_the_list_of_documents():
    listed = LINK.findall((ROOT / "docs" / "README.md").read_text(encoding="utf-8"))
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert pages <= set(listed)
