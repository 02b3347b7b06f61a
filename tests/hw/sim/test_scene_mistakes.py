"""Mistakes in scene files: refused with file, line, column and a hint."""

from pathlib import Path

import pytest

from hw.sim import SceneError, load_scene
from robots import load_robot

FOOTPRINT = load_robot("frankie").base.size[:2]
GOOD = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
"""


# What stands in the file after GOOD => part of the message.
MISTAKES = [
    "objects: {cuont: 2} => 3:11: objects.cuont: unknown key; did you mean `count`?",
    "objects: {kinds: [bal]} => of object is called `bal`; did you",
    "objects: {width_mm: [70, 15]} => 3:21: objects.width_mm: must be the smallest",
    "fixtures:\n  - {name: a} => 4:5: fixtures.0.centre: is missing",
    "objects: {kinds: [mug], width_mm: [50, 60]} => no mug is 50 to 60",
    "fixtures: [{name: a, centre: [1, 1, 1], size: [800, 1, 1]}] => did you mean 0.8?",
    "fixtures: [{name: a, centre: [1, 1, 1e9], size: [1, 1, 1]}] => fixtures.0.centre.2: is 1e+09",
    "fixtures: [{name: a, centre: [1, 1, 1]}] => 3:12: fixtures.0: is neither a box nor a mesh",
    "fixtures: [{name: hand, centre: [1, 1, 1], size: [1, 1, 1]}] => is the name of other",
    'fixtures: [{name: "a\\e[2J", centre: [1, 1, 1], size: [1, 1, 1]}] => fixtures.0.name: is no',
    "fixtures: [{name: a, centre: [1, 1, 0.5], size: [4, 0.1, 1], yaw_deg: 45}] => it stands where",
    "fixtures:" + 101 * "\n- {name: a, centre: [9, 9, 9], size: [1, 1, 1]}" + " => are 101, and",
    "objects: {count: true} => objects.count: expected a whole",
    "side_tables: [{name: a, centre: [1, 1], size: [0.1, 0.1], objects: {}}] => do not fit on a",
    "walkers: [{name: a, way: [[0.3, 0], [3, 0]]}] => 3:11: walkers.0: it stands where the robot",
    "walkers: [{name: a, way: [[1, 1], [1, 1], [2, 2]]}] => two points in a row are the same",
    "objects: {items: [{mass_g: 10}]} => 3:19: objects.items.0: is of no kind and no mesh",
    "objects: {items: [{kind: can, at: [3.3, 0]}]} => 3:31: items.0: at [3.3, 0.0] it does not fit",
    "objects:\n  items:" + 2 * "\n  - {kind: can, at: [3, 0]}" + " => 6:17: items.1: it overlaps",
    "fixtures: [{name: a, centre: [2, 1, 1], size: [1, 1, 1], yaw_deg: 9, objects: {}}] => lie on",
    "objects: {items: [{mesh: a.stl, units: km}]} => 3:40: objects.items.0.units: expected `m`",
    "objects: {items: [{mesh: /dev/zero}]} => there is no file",
    'objects: {items: [{mesh: "a\\0b"}]} => is no name of a file',
    "description: !!python/object/apply:os.system ['touch ran'] => 3:14: the",
    "fixtures: " + 5000 * "[" + 5000 * "]" + " => nests deeper than 64 levels",
]


@pytest.mark.parametrize("number", range(len(MISTAKES)))
def test_a_mistake_is_reported_with_its_place_and_a_hint(number, tmp_path):
    text, told = MISTAKES[number].split(" => ")
    check(f"{GOOD}{text}\n", told, tmp_path / "bad.yaml")


def test_mistakes_in_the_furniture_of_every_scene(tmp_path):
    for text, told in (
        ("table: {}\n", "1:1: table.centre: is missing"),
        ("objects: {count: 1}\n", "1:1: objects: lie in a container, and there is none; add"),
        (GOOD.replace("3.0", "0.2"), "1:1: container: it stands"),
        (GOOD.replace("1.6", "0.5"), "2:1: table: it stands where the robot"),
        (GOOD.replace("3.0", "2935"), "1:22: container.centre.0: is 2935 m"),
        (GOOD.replace("]}", "], wall_thickness: 0}", 1), "greater than 0"),
    ):
        check(text, told, tmp_path / "bad.yaml")


def check(text, told, path):
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


def test_a_scene_that_is_not_found_or_not_readable_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"`houshold`; did you mean `household`\?") as error:
        load_scene("houshold", 0)
    assert "`kitchen`, `long_table`, `on_the_move`, `shapes`" in str(error.value)
    for name in ("x" * 5000, "a\0b", "/proc/self/mem", "/", "\x1b[2J", "", Path("/dev/zero")):
        with pytest.raises(SceneError):
            load_scene(name, 0)
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\xd8")
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene(binary, 0)
