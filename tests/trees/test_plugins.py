"""Packages that offer leaves, installed as pip does it: good ones, and broken ones of all kinds."""

import re
from pathlib import Path

import pytest
import yaml
from command_line import call
from tree_toys import check

from trees.language import known_leaves, plugin_problems

PACKAGES = yaml.safe_load(Path(__file__).with_name("plugins.yaml").read_text("utf-8"))
LEAF = PACKAGES["good"]
PROBLEM = (
    r"behaviour `hello` of `package_\d+:Hello` cannot be used: .+; fix or uninstall its package"
)
UNRELATED = "task: toy\ntree: {wait: {duration_s: 0.02}}\n"
USER = "task: toy\ntree: {hello: {}}\n"


@pytest.fixture
def install_leaf(install):
    return lambda source, name="hello": install(source, "behaviours", name, "Hello")


@pytest.fixture
def task(tmp_path):
    def write(text: str):
        path = tmp_path / "toy.yaml"
        path.write_text(text)
        return str(path)

    return write


def test_a_good_package_adds_a_leaf(install_leaf, task):
    path = task(USER)
    assert "unknown node `hello`" in str(check(path)[0])
    install_leaf(LEAF)
    assert check(path) == []
    assert plugin_problems() == []
    code, _, err = call("dry", path)
    assert (code, err) == (0, "")
    assert "hello" in call("nodes")[1]


@pytest.mark.parametrize("row", PACKAGES["broken"], ids=lambda row: row["what"])
def test_a_broken_package_is_named_and_stops_only_who_uses_it(install_leaf, task, row, tmp_path):
    install_leaf(row.get("source") or LEAF.replace('"hello"', row["key"]))
    run = ("--scene", "single", "--view", "none", "--record", str(tmp_path / "runs"))
    path = task(UNRELATED)
    for arguments in (("check", path), ("dry", path)):
        code, out, err = call(*arguments)
        assert (code, bool(out), err) == (0, True, "")
    code, out, err = call("nodes")
    assert (code, bool(out)) == (0, True)
    (line,) = err.splitlines()
    assert re.fullmatch(rf"warning: {PROBLEM}", line)
    assert row.get("told", "") in line
    assert line.isprintable()
    assert len(line) < 500
    path = task(USER)
    code, out, err = call("run", path, *run)
    assert (code, out) == (2, "")
    assert re.match(rf"{path}:2:8: {PROBLEM}\n", err)
    code, out, err = call("check", path)
    assert code == 2
    assert re.match(rf"{path}:2:8: {PROBLEM} \[R201\]\n", out)
    assert not (tmp_path / "runs").exists()


def test_a_broken_package_takes_no_good_one_along(install_leaf, task):
    install_leaf("raise ValueError('bad')\n", name="bad")
    install_leaf(LEAF)
    install_leaf(LEAF, name="again")
    assert check(task(USER)) == []
    assert plugin_problems() == []
    known_leaves()
    assert [problem.partition("`:")[0] for problem in plugin_problems()]
    assert len(plugin_problems()) == 2
    assert "takes the key `hello`, which is taken" in "".join(plugin_problems())


def test_ctrl_c_during_an_import_is_one(install_leaf, task):
    install_leaf("raise KeyboardInterrupt\n")
    with pytest.raises(KeyboardInterrupt):
        check(task(USER))


@pytest.mark.parametrize(
    ("raised", "told"),
    [
        ("ValueError('odd')", "refuses its parameters: odd; change them"),
        ("KeyError('odd')", "cannot be made: KeyError: 'odd'; correct"),
        ("SystemExit(0)", "cannot be made: SystemExit: 0; correct"),
    ],
)
def test_a_constructor_that_raises_is_refused_before_anything_moves(
    install_leaf, task, tmp_path, raised, told
):
    install_leaf(LEAF + f"    def __init__(self, name, context):\n        raise {raised}\n")
    options = ("--scene", "single", "--view", "none", "--record", str(tmp_path / "runs"))
    path = task(USER)
    code, out, err = call("run", path, *options)
    assert (code, out) == (2, "")
    assert err.startswith(f"{path}:2:8: `hello` {told}")
    assert not (tmp_path / "runs").exists()
