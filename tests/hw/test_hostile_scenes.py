"""Scene files with impossible or hostile content: refused with file, line and column."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from hw.sim import SceneError, load_scene
from robots import load_robot

FOOTPRINT = load_robot("frankie").base.size[:2]
GOOD = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
"""


def fixture(name: str = "a", size: str = "[1, 1, 1]", more: str = "") -> str:
    return f"{GOOD}fixtures:\n  - {{name: {name}, centre: [1, 1, 1], size: {size}{more}}}\n"


HOSTILE = {
    "a yaw that is endless": (fixture(more=", yaw_deg: .inf"), "4:60: fixtures.0.yaw"),
    "a yaw that is no number": (fixture(more=", yaw_deg: .nan"), "4:60: fixtures.0.y"),
    "a yaw of 1e300": (fixture(more=", yaw_deg: 1e300"), "at most 360"),
    "a size of 0": (fixture(size="[0, 1, 1]"), "4:41: fixtures.0.size.0"),
    "a negative size": (GOOD.replace("]}", "], inner_size: [-1, 1]}", 1), "1:46: container.inner"),
    "a size of 1e308": (GOOD.replace("]}", "], inner_size: [1, 1e308]}", 1), "1:49: container.i"),
    "a place far away": (GOOD.replace("3.0", "1e9"), "1:22: container.centre.0: is 1e+09 m"),
    "a place in millimetres": (GOOD.replace("3.0", "2935"), "did you mean 2.935?"),
    "a size in millimetres": (fixture(size="[800, 1, 1]"), "did you mean 0.8?"),
    "a place that is no number": (GOOD.replace("3.0", ".nan"), "1:22: container.centre.0: ex"),
    "a wall of no thickness": (GOOD.replace("]}", "], wall_thickness: 0}", 1), "greater than 0"),
    "an endless mass": (GOOD + "objects: {mass_g: [1, .inf]}\n", "3:23: objects.mass_g.1"),
    "a negative mass": (GOOD + "objects: {mass_g: [-1, 1]}\n", "3:20: objects.mass_g.0"),
    "a mass of 1e30": (GOOD + "objects: {mass_g: [1, 1e30]}\n", "at most 100000"),
    "tiny objects": (GOOD + "objects: {width_mm: [1e-300, 1e-299]}\n", "3:1: objects: no "),
    "huge objects": (GOOD + "objects: {width_mm: [1e300, 1e301]}\n", "3:22: objects.width_mm.0"),
    "a million objects": (GOOD + "objects: {count: 1000000}\n", "3:18: objects.count: expected"),
    "half an object": (GOOD + "objects: {count: 1.5}\n", "3:18: objects.count: expected a whole"),
    "more than fit": (GOOD + "objects: {count: 40}\n", "3:1: objects: 40 do not fit into the"),
    "more than fit on a table": (
        GOOD + "side_tables:\n  - name: a\n    centre: [1, 1]\n    size: [0.1, 0.1]\n"
        "    objects: {count: 2}\n",
        "7:5: objects: 2 do not fit on a; lower",
    ),
    "a table of no size": (
        GOOD + "side_tables: [{name: a, centre: [1, 1], objects: {}, size: [0, 1]}]\n",
        "3:61:",
    ),
    "a motion without time": (
        GOOD + "side_tables:\n  - {name: a, centre: [1, 1], objects: {count: 0},\n"
        "     motion: {along: [0, 1], period_s: 1e-300}}\n",
        "5:40: side_tables.0.motion.period_s",
    ),
    "5000 fixtures": (
        GOOD
        + "fixtures:\n"
        + "".join(f"- {{name: f{i}, centre: [9,9,9], size: [1,1,1]}}\n" for i in range(1000)),
        "fixtures: are 1000, and 100 are possible; leave some out",
    ),
    "a container on the robot": (
        GOOD.replace("3.0", "0.2"),
        "1:1: container: it stands",
    ),
    "a table on the robot": (GOOD.replace("1.6", "0.5"), "2:1: table: it stands where the robot"),
    "a turned fixture on the robot": (
        GOOD + "fixtures: [{name: a, centre: [1, 1, 0.5], size: [4, 0.1, 1], yaw_deg: 45}]\n",
        "fixtures.0: it stands where the robot starts; move it",
    ),
    "a side table on the robot": (
        GOOD + "side_tables: [{name: a, centre: [0, 0], objects: {count: 0}}]\n",
        "3:15: side",
    ),
    "a walker on the robot": (
        GOOD + "walkers: [{name: a, way: [[0.3, 0], [3, 0]]}]\n",
        "3:11: walkers.0: it stands where the robot starts",
    ),
    "a walker that goes nowhere": (
        GOOD + "walkers: [{name: a, way: [[1, 1]]}]\n",
        "3:26: walkers.0.way: expected 2 values, got 1",
    ),
    "a walker that stands still": (
        GOOD + "walkers: [{name: a, way: [[1, 1], [1, 1], [2, 2]]}]\n",
        "walkers.0.way: two points in a row are the same; leave one out",
    ),
    "a walker that flies": (
        GOOD + "walkers: [{name: a, way: [[1, 1], [2, 2]], speed: 300}]\n",
        "3:51: walkers.0.speed: expected",
    ),
    "a walker without a body": (
        GOOD + "walkers: [{name: a, way: [[1, 1], [2, 2]], radius: 0}]\n",
        "walkers.0.radius: expected",
    ),
    "two walkers of one name": (
        GOOD + "walkers:\n" + 2 * "- {name: a, way: [[1, 1], [2, 2]]}\n",
        "4:1: walkers: two of them are called `a`; rename one",
    ),
    "a name with control characters": (
        fixture(name='"a\\e[2J"'),
        "4:12: fixtures.0.name: is",
    ),
    "a name that is taken": (fixture(name="hand"), "is the name of other furniture"),
    "a name of a kilobyte": (fixture(name="a" * 1000), "4:12: fixtures.0.name: is"),
    "no name": (fixture(name='""'), "4:12: fixtures.0.name: is"),
    "two tables of one name": (
        GOOD + "side_tables:\n" + "  - {name: a, centre: [9, 9], objects: {count: 0}}\n" * 2,
        "4:3: side_tables: two of them are called `a`; rename one",
    ),
    "nested deep": (GOOD + "fixtures: " + "[" * 5000 + "]" * 5000, "nests deeper than 64 levels"),
    "nested deep in mappings": (GOOD + "fixtures: " + "{a: " * 5000 + "}" * 5000, "nests deeper"),
    "nested deep in lines": (
        GOOD + "fixtures:\n" + "".join(" " * i + "-\n" for i in range(300)),
        "nests deeper",
    ),
    "anchors and aliases": (
        GOOD + "x0: &x0 [1, 1]\n" + "".join(f"x{i + 1}: &x{i + 1} [*x{i}]\n" for i in range(9)),
        "3:5: anchors and aliases are not supported",
    ),
    "an alias of itself": (
        "container: &a {centre: *a}\ntable: {centre: [0, 2]}\n",
        "1:12: an",
    ),
    "code": (
        GOOD + "description: !!python/object/apply:os.system ['touch ran']\n",
        "3:14: the",
    ),
    "two documents": (GOOD + "---\n" + GOOD, "a second document starts here"),
    "a key twice": (GOOD + GOOD, "the key `container` appears twice"),
    "keys that are lists": (GOOD + "[1]: 2\n", "this key is not a word"),
    "binary": ("\x00\x01", "this is not YAML"),
    "an endless number": (GOOD + "objects: {count: " + "9" * 5000 + "}\n", "objects.count"),
    "an old number": (
        GOOD.replace("3.0", "1:30"),
        "container.centre.0: expected a number",
    ),
    "an old truth": (GOOD + "objects: {count: yes}\n", "objects.count: expected a whole number"),
    "truth for a number": (GOOD + "objects: {count: true}\n", "objects.count: expected a whole"),
    "text for a mapping": (GOOD + "objects: many\n", "3:10: objects: expected a mapping"),
    "an item that is nothing": (
        GOOD + "objects: {items: [{mass_g: 10}]}\n",
        "3:19: objects.items.0: is of no kind and no mesh, or of both; write `kind` or `mesh`",
    ),
    "an item of no kind": (
        GOOD + "objects: {items: [{kind: coffe mug}]}\n",
        "objects.items.0.kind: no kind of object is called `coffe mug`; did you mean `coffee mug`",
    ),
    "an item beside the container": (
        GOOD + "objects: {items: [{kind: can, at: [3.3, 0]}]}\n",
        "3:31: items.0: at [3.3, 0.0] it does not fit into the container, whose middle is at",
    ),
    "an item in another": (
        GOOD + "objects:\n  items:\n" + 2 * "    - {kind: can, at: [3, 0]}\n",
        "6:19: items.1: it overlaps can 1; move one of them",
    ),
    "an item that slides off by itself": (
        GOOD + "objects: {items: [{kind: can, friction: 0}]}\n",
        "3:41: objects.items.0.friction: expected a number of at least 0.05",
    ),
    "a mesh that is a folder": (GOOD + "objects: {items: [{mesh: ..}]}\n", "items.0.mesh: "),
    "a mesh that is a device": (
        GOOD + "objects: {items: [{mesh: /dev/zero}]}\n",
        "there is no file",
    ),
    "a mesh without a name": (
        GOOD + 'objects: {items: [{mesh: "a\\0b"}]}\n',
        "is no name of a file",
    ),
    "a mesh in unknown units": (
        GOOD + "objects: {items: [{mesh: a.stl, units: km}]}\n",
        "3:40: objects.items.0.units: expected `m`, `cm`, `mm` or `in`",
    ),
    "a fixture that is nothing": (
        GOOD + "fixtures: [{name: a, centre: [1, 1, 1]}]\n",
        "3:12: fixtures.0: is neither a box nor a mesh, or both; write `size` or `mesh`",
    ),
    "kinds that are a mapping": (
        GOOD + "objects: {kinds: {a: 1}}\n",
        "kinds: expected a list",
    ),
    "nothing in it": (GOOD + "objects:\n", "3:1: objects: expected a mapping"),
    "larger than any scene": (
        GOOD + "description: " + "x" * 100_000,
        "the file is larger than 64 kB",
    ),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_scene_is_told_where_and_what(kind, tmp_path):
    text, told = HOSTILE[kind]
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(SceneError) as error:
        load_scene(path, 0, FOOTPRINT)
    lines = str(error.value).splitlines()
    assert any(told in line for line in lines), lines[:3]
    for line in lines:
        assert line.startswith(f"{path}:")
        assert "; " in line
        assert line.isprintable()
        assert len(line) < 700


def test_all_mistakes_come_at_once(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(
        "container: {centre: [.nan, 0], wall_height: -1}\ntable: {centre: [0, 0]}\n"
        "objects: {mass_g: [1, .inf], kinds: [bal]}\nmore: 1\n"
    )
    with pytest.raises(SceneError) as error:
        load_scene(path, 0, FOOTPRINT)
    lines = str(error.value).splitlines()
    places = [line.removeprefix(f"{path}:").split(": ")[1] for line in lines]
    assert places == [
        "container.centre.0", "container.wall_height", "table", "objects.mass_g.1", "objects.kinds",
        "more",
    ]  # fmt: skip


def test_what_is_beside_or_above_the_robot_is_no_obstacle(tmp_path):
    path = tmp_path / "good.yaml"
    lamp = "fixtures:\n  - {name: lamp, centre: [0, 0, 2.5], size: [1, 1, 0.1]}\n"
    beside = "  - {name: rail, centre: [0, 0.4, 0.1], size: [4, 0.1, 0.2], yaw_deg: 5}\n"
    path.write_text(GOOD + lamp)
    assert load_scene(path, 0, FOOTPRINT)
    path.write_text(GOOD + "fixtures:\n" + beside)
    assert load_scene(path, 0, FOOTPRINT)


@pytest.mark.parametrize("kind", ["nested deep", "an endless mass", "a container on the robot"])
def test_nothing_has_moved_and_nothing_is_left(kind, tmp_path):
    path, runs = tmp_path / "bad.yaml", tmp_path / "runs"
    path.write_text(HOSTILE[kind][0])
    options = ["--scene", str(path), "--view", "none", "--record", str(runs)]
    result = CliRunner().invoke(app, ["run", "pick_one", *options])
    assert (result.exit_code, result.stdout) == (2, "")
    assert f"{path}:" in result.stderr
    assert not runs.exists()


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "/proc/self/mem", "/", "\x1b[2J", ""])
def test_a_scene_that_is_no_file_is_refused(name):
    with pytest.raises(SceneError):
        load_scene(name, 0)


def test_a_pipe_or_a_device_is_no_scene():
    for path in (Path("/dev/zero"), Path("/dev/stdin")):
        with pytest.raises(SceneError, match="no scene is called"):
            load_scene(path, 0)
