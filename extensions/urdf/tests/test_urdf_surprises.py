"""URDFs that are unlike others: packages, xacro, mimics, legs, hands, limits, names."""

import struct
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from command_line import call
from pinocchio import SE3

from app.live import SceneView, ShownRun
from config import UserError
from controller import RobotModel, SelfCollision, bank, out_of_reach
from controller.floor.floor_map import FloorMap
from extensions.ros2.run_messages import Messages
from extensions.urdf import xacro_file
from extensions.urdf.arm_choice import choose_arm, joint_values
from extensions.urdf.imported_hand import hand_of
from extensions.urdf.importing import ImportOptions, write_robot
from extensions.urdf.urdf_file import Urdf
from hw.motion_monitor import MotionMonitor
from hw.sim import load_fixtures
from robots import load_robot, robot_texts

LEKIWI = Path(__file__).parent / "lekiwi_like.urdf"
BOX = '<collision><origin xyz="0 0 {z}"/><geometry><box size="{size}"/></geometry></collision>'
LIMIT = '<limit lower="{low}" upper="{high}" velocity="2" effort="50"/>'


def link(name: str, inside: str = "") -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, parent: str, child: str, z: float = 0.2, **more: str) -> str:
    """A revolute joint, or as `kind`, `axis`, `limit`, `mimic` and `y` say."""
    mimic = f"<mimic {more['mimic']}/>" if "mimic" in more else ""
    return (
        f'<joint name="{name}" type="{more.get("kind", "revolute")}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="0 {more.get("y", "0")} {z}"/>'
        f'<axis xyz="{more.get("axis", "0 1 0")}"/>{mimic}'
        f"{more.get('limit', LIMIT.format(low=-2, high=2))}</joint>\n"
    )


def arm(last: str = "hand", base: str = "base_link", count: int = 6, **more: str) -> str:
    """`count` joints a1 ... and links l1 ... of which the last is called otherwise."""
    names = [base, *(f"l{k}" for k in range(1, count)), last]
    text = link(base, BOX.format(z=0.05, size="0.1 0.1 0.1"))
    for k in range(1, count + 1):
        text += link(names[k], BOX.format(z=0.08, size="0.05 0.05 0.08"))
        axis = "0 0 1" if k % 2 else "0 1 0"
        text += joint(f"a{k}", names[k - 1], names[k], axis=axis, **more)
    return text


def finger(name: str, parent: str, side: int, mimic: str = "", shape: str = "") -> str:
    shape = shape or BOX.format(z=0.03, size="0.02 0.01 0.06")
    more = {"mimic": mimic} if mimic else {}
    limit = LIMIT.format(low=0, high=0.04)
    return link(f"{name}_link", shape) + joint(
        name,
        parent,
        f"{name}_link",
        0.1,
        kind="prismatic",
        axis=f"0 {side} 0",
        y=f"{0.005 * side}",
        limit=limit,
        **more,
    )


def written(path: Path, *parts: str, head: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<robot name="r"{head}>{"".join(parts)}</robot>')
    return path


XACRO = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'


def imported(path: Path, out: Path, **options: object) -> list[str]:
    return write_robot(path, out, ImportOptions(**options), lambda robot: robot.arm.ready)


def notes_of(path: Path, tool: str | None = None) -> list[str]:
    """Notes about arm and hand, without the search of pairs that can touch."""
    notes: list[str] = []
    hand_of(choose_arm(Urdf(path), None, tool, None, notes), None, None, notes)
    return notes


def refused(path: Path, **options: object) -> str:
    with pytest.raises(UserError) as error:
        imported(path, path.parent / "never", **options)
    assert "\n" not in str(error.value)
    return str(error.value)


def stl(path: Path, size: float) -> None:
    corners = size * np.array(list(product((-0.5, 0.5), repeat=3)))
    sides = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    faces = [*sides, (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    rows = [struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows))


MESH = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def two_packages(folder: Path, mine: str, other: str) -> Urdf:
    """An arm in `mine` that mounts a mesh of the package `other_description`; both have one."""
    stl(folder / mine / "meshes/base.stl", 0.6)
    if other:
        stl(folder / other / "meshes/base.stl", 0.06)
    hand = link("grip", MESH.format("package://other_description/meshes/base.stl"))
    fixed = joint("g", "hand", "grip", kind="fixed")
    return Urdf(written(folder / mine / "urdf/r.urdf", arm(), hand, fixed))


def size_of(urdf: Urdf, link: str) -> float:
    (one,) = [one for one in urdf.geometry.geometryObjects if one.name.startswith(link)]
    one.geometry.computeLocalAABB()
    return float(2.0 * one.geometry.aabb_radius / 3.0**0.5)


@pytest.mark.parametrize(
    ("mine", "other", "note"),
    [
        ("arm_description", "other_description", ""),
        ("src/arms/arm_description", "src/vendor/other_description", "that in"),
        ("src/arm", "src/other-main", ""),  # called so by its package.xml
    ],
)
def test_a_mesh_is_that_of_the_package_that_is_named(tmp_path, mine, other, note):
    if other.endswith("main"):
        (tmp_path / other).mkdir(parents=True)
        manifest = "<package><name>other_description</name></package>"
        (tmp_path / other / "package.xml").write_text(manifest)
    urdf = two_packages(tmp_path, mine, other)
    assert size_of(urdf, "grip") == pytest.approx(0.06, rel=1e-3)
    assert note in " ".join(urdf.notes)
    assert bool(note) == bool(urdf.notes)


def test_what_is_taken_instead_of_a_package_or_of_one_of_two_is_noted(tmp_path):
    alone = two_packages(tmp_path / "a", "arm_description", "")
    assert size_of(alone, "grip") == pytest.approx(0.6, rel=1e-3)
    assert "no package `other_description`" in alone.notes[0]
    stl(tmp_path / "b/old/other_description/meshes/base.stl", 0.07)
    two = two_packages(tmp_path / "b", "arm_description", "other_description")
    assert size_of(two, "grip") == pytest.approx(0.06, rel=1e-3)
    assert "old/other_description" in two.notes[0]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_joint_may_mimic_one_that_mimics(tmp_path, order):
    right = finger("right", "hand", -1, 'joint="left"')
    left = finger("left", "hand", 1, 'joint="motor" multiplier="2" offset="0.001"')
    motor = link("m") + joint("motor", "hand", "m", kind="prismatic")
    parts = right, left, motor
    urdf = Urdf(written(tmp_path / "r.urdf", arm(), *(parts[k] for k in order)))
    assert joint_values(urdf, {"motor": 0.01})["right"] == pytest.approx(0.021)


@pytest.mark.parametrize(
    ("mimics", "why"),
    [
        (('joint="lefd"', ""), ":13: joint `right` mimics `lefd`, which is no joint; did you mean"),
        (('joint="right"', ""), "mimics itself (right -> right)"),
        (('joint="left"', 'joint="right"'), "mimics itself (left -> right -> left)"),
    ],
)
def test_a_mimic_without_a_master_is_refused_with_its_line(tmp_path, mimics, why):
    fingers = finger("left", "hand", 1, mimics[1]) + "\n" * 5
    file = written(tmp_path / "r.urdf", arm(), fingers, finger("right", "hand", -1, mimics[0]))
    assert why in refused(file)


def test_an_arm_whose_joints_move_together_is_told_so(tmp_path):
    text = arm("tool0")
    at = text.index("<limit", text.index('<joint name="a3"'))
    text = f'{text[:at]}<mimic joint="a2"/>{text[at:]}'
    why = refused(written(tmp_path / "r.urdf", text))
    assert "joint `a3` moves with `a2`" in why
    assert "parallelogram" in why


def test_xacro_files_are_expanded_as_xacro_does_it(tmp_path, monkeypatch):
    here = tmp_path / "pkg" / "urdf"
    written(here / "parts/deep/body.xacro", arm(), head=XACRO)
    include = '<xacro:include filename="{}"/>'
    written(here / "parts/mid.xacro", include.format("deep/body.xacro"), head=XACRO)
    (here / "lim.yaml").write_text("up: 1.5\n")
    written(tmp_path / "vendor/gripper_description/g.xacro", link("g1"), head=XACRO)
    visual = '<visual><geometry><mesh filename="package://nowhere/a.dae"/></geometry></visual>'
    main = written(
        here / "main.xacro",
        include.format("parts/mid.xacro") + include.format("$(find gripper_description)/g.xacro"),
        "<xacro:arg name='kind' default='x'/><xacro:property name='c' "
        "value=\"${xacro.load_yaml('lim.yaml')}\"/>",
        link("tool_$(arg kind)", visual),
        joint("t", "hand", "tool_$(arg kind)", limit=LIMIT.format(low=0, high="${c['up']}")),
        joint("f", "hand", "g1", kind="fixed"),
        head=XACRO,
    )
    monkeypatch.chdir(tmp_path)
    urdf = Urdf(main.relative_to(tmp_path), arguments=["kind:=ur5e"])
    assert "tool_ur5e" in urdf.parents
    assert urdf.model.upperPositionLimit[-1] == 1.5
    assert "no argument `kin`; did you mean `kind`?" in refused(main, arguments=["kin:=1"])
    text = main.read_text().replace("find gripper", "find griper")
    main.write_text(text)
    why = refused(main)
    assert "no package is called `griper_description`; say where with --packages" in why
    assert "Exception" not in why


def test_a_macro_without_an_end_is_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(xacro_file, "_LONGEST", 2.0)
    call_itself = "<xacro:m n='${n-1}'/>" * 2
    bomb = (
        f"<xacro:macro name='m' params='n'><xacro:if value='${{n>0}}'>{call_itself}</xacro:if>"
        "</xacro:macro><xacro:m n='40'/>"
    )
    assert "is not expanded" in refused(written(tmp_path / "a.xacro", bomb, head=XACRO))


def test_legs_and_drones_are_no_arms(tmp_path):
    trunk = link("trunk")
    legs = "".join(
        link(f"{k}_thigh") + link(f"{k}_foot") + joint(f"{k}1", "trunk", f"{k}_thigh")
        + joint(f"{k}2", f"{k}_thigh", f"{k}_foot")
        for k in ("lf", "rf", "lh", "rh")
    )  # fmt: skip
    dog = written(tmp_path / "dog.urdf", trunk, legs)
    why = refused(dog)
    assert "4 equal chains on `trunk`" in why
    assert "--tool-frame" in why
    assert notes_of(dog, "lf_foot")
    mounted = legs + arm(base="plate") + joint("m", "trunk", "plate", kind="fixed")
    notes = notes_of(written(tmp_path / "b.urdf", trunk, mounted))
    assert any("tool frame: `hand`" in note for note in notes)
    rotors = "".join(link(f"rotor_{k}") + joint(f"r{k}", "trunk", f"rotor_{k}") for k in range(4))
    assert "it flies" in refused(written(tmp_path / "d.urdf", trunk, rotors))


def test_hands_are_told_as_what_they_are(tmp_path):
    bare = finger("left", "hand", 1, shape=" ") + finger("right", "hand", -1, shape=" ")
    hands = {
        "no collision shapes on what moves by `left`, `right`": bare,
        "one jaw (`left`)": finger("left", "hand", 1),
        "none in the URDF": "",
        "suction, as of `vacuum_cup`, is not supported": link("vacuum_cup")
        + joint("f", "hand", "vacuum_cup", kind="fixed"),
        "gripper: opens by 0.080 m": finger("left", "hand", 1) + finger("right", "hand", -1),
    }
    for number, (words, hand) in enumerate(hands.items()):
        file = written(tmp_path / f"{number}.urdf", arm(), hand)
        assert words in " ".join(notes_of(file))


def hinged(side: float, low: float, high: float) -> str:
    """A body with a fixed jaw 70 mm long at y = 0, and one that turns away from it."""
    fixed = BOX.format(z=0.08, size="0.02 0.01 0.1").replace("0 0 0.08", f"0 {-0.005 * side} 0.08")
    jaw = BOX.format(z=0.04, size="0.02 0.01 0.08").replace("0 0 0.04", f"0 {0.005 * side} 0.04")
    body = BOX.format(z=0.02, size="0.06 0.06 0.04") + fixed
    limit = LIMIT.format(low=low, high=high)
    turns = joint("j", "body", "jaw", 0.05, axis=f"{-side} 0 0", limit=limit)
    held = joint("b", "hand", "body", 0.12, kind="fixed")
    return link("body", body) + held + link("jaw", jaw) + turns


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("low", "high", "wide"), [(0.0, 0.4, 0.4), (0.0, 1.6, 0.72)])
def test_one_jaw_that_closes_on_a_fixed_one_is_a_gripper(tmp_path, side, low, high, wide):
    file = written(tmp_path / "r.urdf", arm(), hinged(side, low, high))
    notes: list[str] = []
    hand = hand_of(choose_arm(Urdf(file), None, None, None, notes), None, None, notes)
    assert f"jaw `j` closes on a fixed one, from {wide:.3g} to 0, opens by" in notes[-1]
    assert hand.opening == pytest.approx(0.06 * np.sin(wide), abs=0.01)
    aside = hand.rTe.translation[1]  # the middle of the opening, beside the fixed jaw
    assert aside == pytest.approx(side * hand.opening / 2.0, abs=1e-6)
    assert abs(hand.rTe.rotation[1, 1]) == pytest.approx(1.0)
    assert hand.rTe.translation[2] == pytest.approx(0.25 - 0.01, abs=0.003)
    centre, size = hand.palm
    assert -0.09 < centre[2] + size[2] / 2.0 < -0.03
    assert len(hand.collision) == 2


def test_a_small_mobile_manipulator_with_one_jaw_is_imported_unedited(tmp_path):
    code, told, _ = call("robot", "import", LEKIWI, "-o", tmp_path / "leki")
    assert code == 0
    for words in (
        "gripper: jaw `gripper` closes on a fixed one",
        "drive: omni, by its 3 wheels",
        "camera on `front_camera_optical_frame`: not on the hand; a D435 is assumed",
        "accelerations: 6 rad/s^2 (--acceleration), lag: 0.03 s",
    ):
        assert words in told
    robot = load_robot(tmp_path / "leki")
    assert robot.gripper.grasps
    assert 0.04 < robot.gripper.opening < 0.08
    assert robot.limits.base_twist[1] > 0.0
    assert robot.base.size[2] < 0.11
    model = RobotModel(robot)
    assert SelfCollision(model).clearance(robot.arm.ready) > 0.005
    assert model.bTe(robot.arm.ready).translation[0] > 0.1


def test_arms_are_as_swift_as_their_reach_and_their_torques_allow(tmp_path):
    inertia = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" '
    text = arm().replace("<collision>", f'{inertia}ixz="0" iyz="0"/></inertial><collision>')
    cases = {"s": text, "long": text.replace("0 0 0.2", "0 0 0.6"), "weak": text}
    cases["heavy"] = text.replace('effort="50"', "").replace('mass value="1"', 'mass value="99"')
    cases["weak"] = text.replace('effort="50"', 'effort="25"', 2).replace('effort="25"', 'x="1"', 1)
    found, strong = {}, {}
    for name, one in cases.items():
        notes = imported(written(tmp_path / f"{name}.urdf", one), tmp_path / name)
        robot = load_robot(tmp_path / name)
        found[name] = robot.limits.qdd, robot.arm.lag, " ".join(notes)
        strong[name] = robot.arm.torque
    assert found["s"][0].max() == pytest.approx(6.0)
    assert found["long"][0][0] == pytest.approx(6.0 * 1.1 / 3.12, rel=0.05)
    assert found["long"][0][-1] == pytest.approx(6.0)
    assert found["long"][1] == pytest.approx(0.03 * 3.12 / 1.1, rel=0.05)
    assert "the torques of `a2`" in found["weak"][2]
    assert 0.0 < found["weak"][0][1] < 6.0
    assert strong["s"].max() == 50.0
    assert strong["heavy"][1] > 99.0 * 9.81 * (0.2 + 0.4 + 0.6 + 0.8)  # it holds its links


def test_limits_that_are_none_or_degrees(tmp_path):
    endless = '<limit lower="-1e16" upper="1e16" effort="1e30" velocity="1e16"/>'
    notes = imported(written(tmp_path / "e.urdf", arm(limit=endless)), tmp_path / "e")
    assert np.isinf(load_robot(tmp_path / "e").limits.q_max).all()
    assert any("speed limit of 1e+16, not believed" in note for note in notes)
    degrees = written(tmp_path / "d.urdf", arm(limit=LIMIT.format(low=-170, high=170)))
    assert "looks like degrees" in refused(degrees)


SMALL = """<inertial><mass value="0.01"/><inertia ixx="6e-7" iyy="6e-7" izz="6e-7" ixy="0" ixz="0"
 iyz="0"/></inertial>"""


def test_small_robots_and_shared_names_are_imported(tmp_path):
    text = arm().replace("<collision>", SMALL + "<collision>").replace('name="a6"', 'name="hand"')
    imported(written(tmp_path / "s.urdf", text), tmp_path / "s")
    robot = load_robot(tmp_path / "s")
    assert len(robot.arm.inertias) == 7
    assert robot.arm.names == ("a1", "a2", "a3", "a4", "a5", "hand")


def test_joints_keep_their_names_in_messages(tmp_path):
    imported(written(tmp_path / "s.urdf", arm()), tmp_path / "s")
    robot = load_robot(tmp_path / "s")
    assert [name for name, _ in robot.arm.links][:2] == ["base_link", "l1"]
    assert robot.arm.called(2) == "joint `a3`"
    assert load_robot("frankie").arm.called(2) == "joint 3"
    assert MotionMonitor(robot)._called(0) == "joint `a1`"
    shown = ShownRun(robot, (), SceneView(), 0)
    assert Messages(shown)._joints[:2] == ["a1", "a2"]
    assert "l1" in [name for _, name, _ in Messages(shown)._urdf]


def test_an_arm_without_shapes_stands_among_furniture_and_has_no_contact(tmp_path):
    text = arm().replace("collision>", "other>")
    imported(written(tmp_path / "s.urdf", text), tmp_path / "s")
    robot = load_robot(tmp_path / "s")
    robot = replace(robot, arm=replace(robot.arm, may_touch=(), collision=((),) * 7))
    assert SelfCollision(RobotModel(robot)).clearance(robot.arm.ready) > 1.0
    floor = FloorMap(load_fixtures("household"), robot)
    assert floor.stands_free(np.zeros((1, 3))).shape == (1,)


def test_shapes_that_are_drawn_stand_for_collision_shapes_if_there_are_none(tmp_path):
    drawn = written(tmp_path / "s.urdf", arm().replace("collision>", "visual>"))
    both = written(tmp_path / "t.urdf", arm(), link("cover", BOX.replace("collision>", "visual>")))
    both.write_text(both.read_text().replace("</robot>", joint("c", "hand", "cover") + "</robot>"))
    assert "the shapes that are drawn" in " ".join(imported(drawn, tmp_path / "s"))
    assert all(load_robot(tmp_path / "s").arm.collision[1:6])
    assert Urdf(both).geometry.ngeoms == Urdf(drawn).geometry.ngeoms == 7


def test_a_mast_is_no_base(tmp_path):
    low = BOX.format(z=0.1, size="0.4 0.4 0.2")
    mast = BOX.format(z=0.65, size="0.07 0.07 1.3")
    wheels = "".join(
        link(f"wheel_{k}") + joint(f"wheel_{k}_joint", "base_link", f"wheel_{k}", kind="continuous")
        for k in "lr"
    )
    text = arm().replace(BOX.format(z=0.05, size="0.1 0.1 0.1"), low + mast) + wheels
    imported(written(tmp_path / "m.urdf", text), tmp_path / "m")
    robot = load_robot(tmp_path / "m")
    assert robot.base.size == (0.4, 0.4, 0.2)
    (one,) = robot.arm.collision[0]
    assert 2.0 * one.shape.half[2] == pytest.approx(1.3, rel=0.01)
    bases = np.random.default_rng(0).uniform([-1, -2, -3], [4, 3, 3], (500, 3))
    free = FloorMap(load_fixtures("kitchen"), robot).stands_free(bases)
    for axis in "xz":  # the frame of its foot may be turned any way
        turn = SE3(pin.utils.rotate(axis, np.pi / 2.0), np.zeros(3))
        foot = (turn.inverse() * robot.arm.joints[0], *robot.arm.joints[1:])
        shapes = ((one.moved(turn.inverse()),), *robot.arm.collision[1:])
        arm_ = replace(robot.arm, joints=foot, collision=shapes)
        turned = replace(robot, bTa=robot.bTa * turn, arm=arm_)
        seen = FloorMap(load_fixtures("kitchen"), turned).stands_free(bases)
        np.testing.assert_allclose(seen, free, atol=1e-9)


def test_what_a_base_that_stands_still_does_not_reach_is_told_before_it_moves(tmp_path):
    robot = load_robot("frankie")
    limits = replace(robot.limits, base_twist=np.full(3, 1e-6), base_reverse=1e-6)
    still, model = replace(robot, limits=limits), RobotModel(robot)
    for q in bank(robot).q[::6000]:
        oTe = model.bTe(q)
        assert not out_of_reach(still, oTe)
        oTe.translation = oTe.translation + np.array([3.0, 0.0, 0.0])
        assert "stands still" in out_of_reach(still, oTe)
        assert not out_of_reach(robot, oTe)


def test_what_a_run_keeps_of_a_robot_describes_the_same(tmp_path):
    for name in ("omni", "emulated"):
        for file, text in robot_texts(name).items():
            (tmp_path / name / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name / file).write_text(text)
        kept, robot = load_robot(tmp_path / name / f"{name}.yaml"), load_robot(name)
        assert kept.name == robot.name
        assert kept.arm.is_like(robot.arm)
        assert (kept.bTa.homogeneous == robot.bTa.homogeneous).all()
        assert (kept.limits.base_twist == robot.limits.base_twist).all()
        assert (kept.base.lag, kept.arm.lag) == (robot.base.lag, robot.arm.lag)


def test_a_run_is_read_again_when_its_robot_has_moved(tmp_path, monkeypatch):
    for file, text in robot_texts("omni").items():
        (tmp_path / "mine" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "mine" / file.replace("omni", "mine")).write_text(text)
    task = "task: t\nscene: household\ntree:\n  drive: {forward_m: 0.05}\n"
    (tmp_path / "t.yaml").write_text(task)
    monkeypatch.chdir(tmp_path)
    given = ("t.yaml", "--robot", "mine", "--view", "none", "--speed", "max")
    assert call("run", *given, "--record", "runs")[0] == 0
    (tmp_path / "mine").rename(tmp_path / "away")
    (folder,) = (tmp_path / "runs").iterdir()
    monkeypatch.chdir("/")
    code, _, error = call("mcap", folder, tmp_path / "o.mcap")
    assert code == 0, error
    page = tmp_path / "e.html"
    assert call("report", folder, page)[0] == 0
    assert "<svg" in page.read_text()


def test_what_is_wrong_is_told_without_the_name_of_a_temporary_file(tmp_path):
    file = written(tmp_path / "r.urdf", arm(limit=LIMIT.format(low=0, high=1e-7)))
    why = refused(file)
    assert "the lower bound comes first" in why
    assert "arm.yaml" not in why


def test_a_task_on_a_base_that_stands_still_is_checked(tmp_path):
    imported(written(tmp_path / "s.urdf", arm()), tmp_path / "s", drive="none")
    task = (
        "task: t\nposes:\n  far: {xyz: [3, 0, 0.7], rpy_deg: [180, 0, 0]}\ntree:\n  sequence:\n"
        "  - navigate: {to: far}\n  - drive: {forward_m: 1.0}\n"
    )
    (tmp_path / "t.yaml").write_text(task)
    code, output, error = call("check", tmp_path / "t.yaml", "--robot", tmp_path / "s")
    assert code == 2
    assert "`far`: out of reach: the base stands still" in output + error
    assert "the base of `s` stands still" in output + error
