"""A simulated Frankie that speaks ROS 2 only, in a process of its own.

Its types and its CDR are not those of the driver. Arguments: domain, scene, seed. Statements on its
input do things to `node`.
"""

import json
import os
import random
import sys
import threading
import time
from collections import deque
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pinocchio as pin
import scipy.optimize  # noqa: F401 - the first grip must not wait for it
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from ros_types import T, header, image

from drivers.processes.child import hurry
from hw import WallClock
from hw.sim import (
    D435Noise,
    DepthRenderer,
    Dynamics,
    KinematicBody,
    SimLaser,
    load_localisation,
    load_scene,
    made_wrong,
)
from robots import Intrinsics, load_robot

LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/>'
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>'
)
JOINTS = [f"panda_joint{k}" for k in range(1, 8)]
RELIABLE = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(10))
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))

GRIPPER = "panda_gripper/gripper_action/_action"
WRITES = (
    ("rt/joint_states", "JointState", RELIABLE),
    ("rt/odom", "Odometry", RELIABLE),
    ("rt/amcl_pose", "PoseWithCovarianceStamped", RELIABLE),
    ("rt/camera/depth/image_rect_raw", "Image", SENSOR),
    ("rt/camera/depth/camera_info", "CameraInfo", SENSOR),
    ("rt/scan", "LaserScan", SENSOR),
    (f"rr/{GRIPPER}/send_goalReply", "GripperCommand_SendGoal_Response", RELIABLE),
    (f"rr/{GRIPPER}/get_resultReply", "GripperCommand_GetResult_Response", RELIABLE),
)
READS = (
    ("rt/cmd_vel", "Twist"),
    ("rt/velocity_controller/commands", "Float64MultiArray"),
    (f"rq/{GRIPPER}/send_goalRequest", "GripperCommand_SendGoal_Request"),
    (f"rq/{GRIPPER}/get_resultRequest", "GripperCommand_GetResult_Request"),
    (f"rq/{GRIPPER}/cancel_goalRequest", "CancelGoal_Request"),
)


class Node:
    """The robot and its topics."""

    def __init__(self, domain: int, scene: str, seed: int) -> None:
        description = load_robot("frankie")
        self.truth = load_scene(scene, seed, description.base.size[:2])
        _, process, _ = made_wrong(description, load_localisation("exact"), seed)
        dynamics = Dynamics(period=0.05)
        self.body = KinematicBody(description, self.truth, WallClock(), dynamics, process)
        self.laser = SimLaser(self.body, description.laser, seed)
        full = description.camera.intrinsics
        half = Intrinsics(
            width=full.width // 2, height=full.height // 2, fx=full.fx / 2, fy=full.fy / 2,
            cx=full.cx / 2 - 0.25, cy=full.cy / 2 - 0.25,
        )  # fmt: skip
        self.camera = replace(description.camera, intrinsics=half)
        self.renderer, self.lock = DepthRenderer(half), threading.Lock()
        self.domain = Domain(domain, LOOPBACK)
        self.participant = DomainParticipant(domain)
        here = self.participant
        self.writers = {
            topic: DataWriter(here, Topic(here, topic, T[kind]), qos=qos)
            for topic, kind, qos in WRITES
        }
        self.readers = {
            topic: DataReader(here, Topic(here, topic, T[kind]), qos=RELIABLE)
            for topic, kind in READS
        }
        self.delay, self.shuffles, self.rng = 0.0, False, random.Random(seed)
        self.spoils: dict = {}  # by topic, what makes a message malformed
        self.map = ""  # frame of the place that is told; none is without it
        self.dies = np.inf  # so long after the first command [s]
        self.late: deque = deque()  # what is under way: when it is due, and what to do then
        self.twist, self.qd = np.zeros(3), np.zeros(7)
        self.heard = {"base": -1e9, "arm": -1e9}
        self.timeouts = {"base": 0.5, "arm": 0.5}  # of commands, as of diff_drive_controller [s]
        self.began, self.results = 0.0, []
        self.seen: dict = {"moved": 0.0, "commanded": 0.0, "hit": ""}
        self.scan = None

    def later(self, do, *arguments) -> None:
        self.late.append((time.monotonic() + self.delay, do, arguments))

    def run(self) -> None:
        while True:
            self.hear()
            with self.lock:
                self.move()
                self.tell()
            due = []
            while self.late and self.late[0][0] <= time.monotonic():
                due.append(self.late.popleft())
            if self.shuffles:
                self.rng.shuffle(due)
            for _, do, arguments in due:
                do(*arguments)
            time.sleep(0.008)

    def hear(self) -> None:
        for topic, reader in self.readers.items():
            for sample in reader.take(N=10):
                if not type(sample).__name__.startswith("Invalid"):
                    self.later(self.take, topic, sample)

    def take(self, topic: str, sample) -> None:
        if topic == "rt/cmd_vel":
            self.twist = np.array([sample.linear.x, 0.0, sample.angular.z])
            self.note("base", self.twist)
        elif topic.startswith("rt/velocity"):
            self.qd = np.array(sample.data)
            self.note("arm", self.qd)
        elif topic.endswith("send_goalRequest"):
            self.body.grip(2.0 * sample.position, sample.max_effort)
            answer, stamp = T["GripperCommand_SendGoal_Response"], T["Time"](0, 0)
            told = answer(sample.client, sample.number, True, stamp)
            self.send(f"rr/{GRIPPER}/send_goalReply", told)
        elif topic.endswith("get_resultRequest"):
            self.results.append(sample)

    def note(self, part: str, velocity: np.ndarray) -> None:
        self.heard[part] = now = time.monotonic()
        if velocity.any():
            self.began = self.began or now
            self.seen["commanded"] = now
            if now > self.began + self.dies:
                os._exit(0)

    def move(self) -> None:
        now = time.monotonic()
        twist, qd = (
            told if now - self.heard[part] < self.timeouts[part] else np.zeros_like(told)
            for part, told in (("base", self.twist), ("arm", self.qd))
        )
        self.body.advance()
        if what := self.body.reflex.reason or self.body.bumper.reason:
            self.seen["hit"] = what
        self.body.follow(base_twist=twist, qd=qd)

    def send(self, topic: str, sample) -> None:
        if topic in self.spoils:
            exec(self.spoils[topic], {"one": sample, "nan": float("nan")})
        self.writers[topic].write(sample)

    def tell(self) -> None:
        state, head = self.body, header()
        if max(np.abs(state.base_twist).max(), np.abs(state.qd).max()) > 0.01:
            self.seen["moved"] = time.monotonic()
        names = [*JOINTS, "panda_finger_joint1"]
        rows = list(zip(names, [*state.q, state.width / 2.0], [*state.qd, 0.0], strict=True))
        self.rng.shuffle(rows)
        names, q, qd = zip(*rows, strict=True)
        joints = T["JointState"](head, list(names), [*map(float, q)], [*map(float, qd)], [])
        self.later(self.send, "rt/joint_states", joints)
        v, _, w = state.base_twist.tolist()
        twist = T["Twist"](T["Vector3"](v, 0.0, 0.0), T["Vector3"](0.0, 0.0, w))
        turn = pin.Quaternion(state.wTb.rotation).coeffs().tolist()
        place = T["Point"](*state.wTb.translation.tolist())
        pose = T["PoseWithCovariance"](T["Pose"](place, T["Quaternion"](*turn)), [0.0] * 36)
        moves = T["TwistWithCovariance"](twist, [0.0] * 36)
        self.later(self.send, "rt/odom", T["Odometry"](head, "base_link", pose, moves))
        if self.map:
            told = T["Header"](head.stamp, self.map)
            self.later(
                self.send, "rt/amcl_pose", T["PoseWithCovarianceStamped"](told, deepcopy(pose))
            )
        self.look(head)
        if self.results and not state.fingers_move:
            for one in self.results:
                made = T["GripperCommand_GetResult_Response"]
                result = made(one.client, one.number, 4, state.width / 2.0, 0.0, False, True)
                self.send(f"rr/{GRIPPER}/get_resultReply", result)
            self.results.clear()

    def film(self) -> None:
        """Images of half the size, some fifteen a second."""
        camera, number = self.camera, 0
        while True:
            number, begun = number + 1, time.monotonic()
            with self.lock:
                shapes, wTc, head = self.body.shapes(), self.body.wTe * camera.eTc, header()
            rng = np.random.default_rng((1, number))
            depth = D435Noise().apply(self.renderer.render(shapes, wTc), camera, rng)
            k, region = camera.intrinsics.matrix.ravel().tolist(), T["RegionOfInterest"](*[0] * 5)
            size = camera.intrinsics.height, camera.intrinsics.width
            turn, model = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ("plumb_bob", [0.0] * 5)
            info = T["CameraInfo"](head, *size, *model, k, turn, [0.0] * 12, 0, 0, region)
            self.later(self.send, "rt/camera/depth/camera_info", info)
            self.later(self.send, "rt/camera/depth/image_rect_raw", image(depth, head))
            time.sleep(max(0.06, 2.0 * (time.monotonic() - begun)))  # on a slow computer: fewer

    def look(self, head) -> None:
        scan, laser = self.laser.latest(), self.body.description.laser
        if scan is not self.scan:
            self.scan = scan
            low, high, step = laser.angles[0], laser.angles[-1], laser.angles[1] - laser.angles[0]
            numbers = map(float, (low, high, step, 0.0, 0.1, 0.02, laser.max_range))
            message = T["LaserScan"](head, *numbers, scan.ranges.tolist(), [])
            self.later(self.send, "rt/scan", message)


def main() -> None:
    node = Node(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]))

    def listen() -> None:
        for line in sys.stdin:
            exec(line, {"node": node})
            supports = sorted(node.truth.supports().values())
            print(json.dumps(node.seen | {"supports": supports}), flush=True)
        os._exit(0)

    hurry()  # and its threads
    sys.setswitchinterval(2e-4)  # who films waits for who moves, and for each message of theirs
    for work in (listen, node.film):
        threading.Thread(target=work, daemon=True).start()
    print("ready", flush=True)
    node.run()


if __name__ == "__main__":
    main()
