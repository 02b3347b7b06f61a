"""A stand-in for robosuite, which needs other versions of NumPy and MuJoCo than the project.

Its one task is `Lift`: the Panda of example-robot-data on a base of three joints, a table, a cube.
"""

import re
from types import SimpleNamespace

import mujoco
import numpy as np
from example_robots import EXAMPLES

ALL_ENVIRONMENTS = ("Lift",)
PANDA = EXAMPLES / "panda_description"
BOX, HINGE, SLIDE = (
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtJoint.mjJNT_HINGE,
    mujoco.mjtJoint.mjJNT_SLIDE,
)
BASE = {"forward": (SLIDE, (1, 0, 0)), "side": (SLIDE, (0, 1, 0)), "yaw": (HINGE, (0, 0, 1))}


def make(name, *, seed, **_):
    """What the example uses of an environment of robosuite."""
    spec = mujoco.MjSpec()
    box = {"type": BOX, "friction": (1.0, 0.005, 1e-4)}
    spec.worldbody.add_geom(pos=(0, 0, 0.775), size=(0.4, 0.4, 0.025), **box)
    place = np.random.default_rng(seed).uniform(-0.03, 0.03, 2)
    cube = spec.worldbody.add_body(name="cube", pos=(*place, 0.82))
    cube.add_freejoint()
    cube.add_geom(size=(0.02, 0.02, 0.02), mass=0.08, **box)
    foot = spec.worldbody.add_body(name="robot0_base", pos=(-0.56, 0, 0))
    base = foot.add_body(mass=50, inertia=(5, 5, 5))
    for axis, (kind, direction) in BASE.items():
        base.add_joint(name=f"mobilebase0_joint_mobile_{axis}", type=kind, axis=direction)
        motor(spec, f"mobilebase0_joint_mobile_{axis}", 1000, (0, 0, -1000), most=1)
    column = base.add_body(pos=(0, 0, 0.9), mass=10, inertia=(1, 1, 1))
    column.add_joint(name="mobilebase0_joint_torso_height", type=SLIDE, axis=(0, 0, 1))
    motor(spec, "mobilebase0_joint_torso_height", 1, most=1e5)
    spec.attach(panda(), prefix="robot0_", frame=column.add_frame())
    for number in range(1, 8):
        motor(spec, f"robot0_joint{number}", 1, most=80 if number < 6 else 12)
    for number in (1, 2):
        spec.joint(f"robot0_finger_joint{number}").name = f"gripper0_right_finger_joint{number}"
        motor(spec, f"gripper0_right_finger_joint{number}", 1000, (0, -1000, -50), most=0.04)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return SimpleNamespace(
        sim=SimpleNamespace(model=SimpleNamespace(_model=model), data=SimpleNamespace(_data=data)),
        reset=lambda: None,
        _check_success=lambda: data.body("cube").xpos[2] > 0.84,
    )


def panda():
    """The arm and hand of example-robot-data; the joints of the fingers as in robosuite."""
    text = (PANDA / "urdf/panda.urdf").read_text()
    text = re.sub(r"<visual>.*?</visual>|<mimic[^>]*>", "", text, flags=re.DOTALL)
    text = re.sub(r"panda_(?=link|joint|finger)", "", text)
    text = text.replace("package://example-robot-data/robots/panda_description", str(PANDA))
    spec = mujoco.MjSpec.from_string(text)
    other = spec.joint("finger_joint2")
    other.axis, other.range = (0, 1, 0), (-0.04, 0.0)
    for joint in spec.joints:
        joint.armature, joint.damping = 0.1, (0.1, 0.0, 0.0)
    return spec


def motor(spec, joint, gain, bias=(0, 0, 0), *, most):
    spec.add_actuator(
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gainprm=(gain, *[0] * 9),
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=(*bias, *[0] * 7),
        ctrlrange=(-most, most),
        forcerange=(-600, 600),
    )
