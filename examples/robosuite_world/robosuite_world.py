"""The tasks of robosuite as a world: its robot PandaOmron, its physics, its judge."""

import mujoco
import numpy as np
from pinocchio import SE3

from frankie_task import (
    ArmState,
    Backend,
    BaseState,
    ComposedRobot,
    DepthImage,
    GripperState,
    PassivePart,
    SimClock,
    UserError,
    WorldOptions,
    load_robot,
)

BASE = [f"mobilebase0_joint_{name}" for name in ("mobile_forward", "mobile_side", "mobile_yaw")]
COLUMN = "mobilebase0_joint_torso_height"
ARM = [f"robot0_joint{number}" for number in range(1, 8)]
FINGERS = ["gripper0_right_finger_joint1", "gripper0_right_finger_joint2"]
OF_BASE, OF_ARM, OF_FINGERS = slice(0, 3), slice(4, 11), slice(11, 13)
SERVED = 11  # all but the fingers, which have servos of robosuite

STIFFNESS, DAMPING = 1600.0, 80.0  # of the servo of each joint, for an inertia of 1 [1/s², 1/s]
LEAD = 0.05  # by which what a joint is told may run ahead of it [m, rad]
CLOSED = 0.001  # between the pads where the joints of the fingers are 0 [m]
STILL, STARTING = 0.004, 0.1  # fingers move above this speed, or this long after a grip [m/s, s]
IMAGES = 10.0  # a second; each pixel costs a ray
SOLID = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8)  # groups of shapes; the others are decoration
NORMALS = [None] if mujoco.mj_version() >= 3005000 else []  # newer engines can return them


class Simulation:
    """The engine of an environment; servos on its motors follow velocities."""

    def __init__(self, env, described, clock):
        self.model, self.data = env.sim.model._model, env.sim.data._data
        self.described, self.clock, self._steps = described, clock, 0
        joints = [self.model.joint(name) for name in (*BASE, COLUMN, *ARM, *FINGERS)]
        driven = self.model.actuator_trnid[:, 0].tolist()
        self._q, self._v, self._motors = np.array(
            [(one.qposadr[0], one.dofadr[0], driven.index(one.id)) for one in joints]
        ).T
        self._told, self._velocity = self.q[:SERVED], np.zeros(SERVED)
        self._is_weak = np.zeros(SERVED, bool)  # whether its motor is at its limit
        self.gripped_at = -STARTING
        self.wRf = self.pose("robot0_base").rotation  # of the axes of the base's joints

    q = property(lambda self: self.data.qpos[self._q])
    v = property(lambda self: self.data.qvel[self._v])

    def pose(self, body):
        found = self.data.body(body)
        return SE3(found.xmat.reshape(3, 3).copy(), found.xpos.copy())

    def advance(self):
        """Step until the present, which is returned."""
        now, step = self.clock.now(), self.model.opt.timestep
        while (self._steps + 0.5) * step < now:
            self._servo(step)
            mujoco.mj_step(self.model, self.data)
            self._steps += 1
        mujoco.mj_kinematics(self.model, self.data)
        return now

    def follow(self, joints, velocity):
        """Returns the velocity, or what a motor at its limit makes of it."""
        self.advance()
        self._velocity[joints] = velocity
        return np.where(self._is_weak[joints], self.v[joints], velocity)

    def _servo(self, step):
        """By inverse dynamics, with what gravity and dry friction take."""
        model, data, dofs, motors = self.model, self.data, self._v[:SERVED], self._motors[:SERVED]
        q, v, goal = self.q[:SERVED], self.v[:SERVED], self._velocity
        self._told = np.clip(self._told + step * goal, q - LEAD, q + LEAD)
        wanted, force = np.zeros((2, model.nv))
        wanted[dofs] = STIFFNESS * (self._told - q) + DAMPING * (goal - v)
        mujoco.mj_mulM(model, data, force, wanted)
        force += data.qfrc_bias - data.qfrc_passive
        force[dofs] += model.dof_frictionloss[dofs] * np.tanh(goal / 0.01)
        gain, slope = model.actuator_gainprm[motors, 0], model.actuator_biasprm[motors, 2]
        data.ctrl[motors] = told = (force[dofs] - slope * v) / gain
        least, most = model.actuator_ctrlrange[motors].T
        self._is_weak = (told < least) | (told > most)

    def grip(self, width, force):
        self.gripped_at = self.advance()
        motors, half = self._motors[OF_FINGERS], (width - CLOSED) / 2.0
        self.model.actuator_forcerange[motors] = -force, force
        self.data.ctrl[motors] = half, -half

    def distances(self, origin, rays):
        """Along rays (n, 3) to what they meet, in lengths of the ray; NaN for nothing."""
        count, lengths = len(rays), np.linalg.norm(rays, axis=1)
        which, found = np.zeros(count, np.int32), np.zeros(count)
        flat, scene = (rays / lengths[:, None]).ravel(), (self.model, self.data)
        mujoco.mj_multiRay(
            *scene, origin, flat, SOLID, True, -1, which, found, *NORMALS, count, 10.0
        )
        return np.where(which >= 0, found / lengths, np.nan)


class Part(PassivePart):
    joints = slice(0)

    def __init__(self, simulation):
        self._simulation, self._described = simulation, simulation.described

    def stop(self):
        self._simulation.follow(self.joints, 0.0)


class Arm(Part):
    joints = OF_ARM

    def read(self):
        stamp, q, v = self._simulation.advance(), self._simulation.q, self._simulation.v
        return ArmState(stamp=stamp, q=q[OF_ARM], qd=v[OF_ARM])

    def send(self, qd):
        return self._simulation.follow(OF_ARM, qd)


class Base(Part):
    """Its middle is below the foot of the arm; its joints move along axes of the world."""

    joints = OF_BASE

    def read(self):
        stamp, oTb, turned = self._simulation.advance(), self._wTb(), self._turned()
        return BaseState(stamp=stamp, oTb=oTb, twist=turned.T @ self._simulation.v[OF_BASE])

    def send(self, twist):
        turned = self._turned()
        return turned.T @ self._simulation.follow(OF_BASE, turned @ twist)

    def _wTb(self):
        return self._simulation.pose("robot0_link0") * self._described.bTa.inverse()

    def _turned(self):
        """From a twist in the base to rates of its joints; about z they are the same."""
        return self._simulation.wRf.T @ self._wTb().rotation


class Gripper(Part):
    def read(self):
        stamp, speed = self._simulation.advance(), np.abs(self._simulation.v[OF_FINGERS]).max()
        left, right = self._simulation.q[OF_FINGERS]
        moving = speed > STILL or stamp < self._simulation.gripped_at + STARTING
        return GripperState(stamp=stamp, width=float(left - right) + CLOSED, moving=bool(moving))

    def grip(self, width, force):
        self._simulation.grip(width, force)


class Camera(Part):
    _number, _image = -1, None

    def latest(self):
        stamp, described = self._simulation.advance(), self._described
        if (number := int(stamp * IMAGES + 1e-9)) != self._number:
            self._number, of = number, described.camera.intrinsics
            u, v = np.meshgrid(np.arange(of.width), np.arange(of.height))
            pixels = (u - of.cx) / of.fx, (v - of.cy) / of.fy, np.ones(u.shape)
            wTe = self._simulation.pose("robot0_link7") * described.arm.lTh * described.gripper.hTe
            wTc = wTe * described.camera.eTc
            rays = np.stack(pixels, axis=-1).reshape(-1, 3) @ wTc.rotation.T
            depth = self._simulation.distances(wTc.translation, rays).reshape(u.shape)
            seen = (described.camera.min_range < depth) & (depth < described.camera.max_range)
            depth = np.where(seen, depth, np.nan).astype(np.float32)
            self._image = DepthImage(depth=depth, stamp=stamp)
        return self._image

    def faults(self):
        return ()


class JudgedRobot(ComposedRobot):
    def close(self):
        super().close()
        self.judge()


def robosuite_world(robot: str, options: WorldOptions) -> Backend:
    """`robosuite:NAME`, an environment such as `Lift`; the run's seed is its seed."""
    import robosuite

    if options.argument not in robosuite.ALL_ENVIRONMENTS:
        known = ", ".join(sorted(robosuite.ALL_ENVIRONMENTS))
        raise UserError(f"no task of robosuite is called `{options.argument}`; known: {known}")
    silent = dict.fromkeys(("has_renderer", "has_offscreen_renderer", "use_camera_obs"), False)
    env = robosuite.make(options.argument, robots="PandaOmron", seed=options.seed, **silent)
    env.reset()
    described, clock = load_robot(robot), SimClock(paced=options.paced)
    simulation = Simulation(env, described, clock)
    parts = {"arm": Arm, "base": Base, "gripper": Gripper, "camera": Camera}
    made = {kind: part(simulation) for kind, part in parts.items()}
    if abs(made["base"].read().oTb.translation[2]) > 0.01:
        raise UserError(f"--robot {robot}: in robosuite it is panda_omron.yaml, beside this world")

    def judge():
        verdict = "success" if env._check_success() else "no success"
        if options.announce:
            options.announce(f"judged by robosuite: {verdict}")

    composed = JudgedRobot(described, **made, clock=clock)
    composed.judge = judge
    return Backend(robot=composed, clock=clock, truth=None, world="robosuite")
