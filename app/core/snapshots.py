"""Snapshots of a run for recorder, page and terminal."""

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core.session import Tick
from app.live import NodeStatus, PoseEstimate, SceneView, Snapshot
from behaviours import BasePose, Leaf, Localiser, Region, TaskLog, ToolPose
from hw import DEFAULT_LEVEL, DepthFrame, TaskTime, TrueObject, Truth
from robots import Geom, RobotDescription
from trees.language import TreeNode

_STATUS = attrgetter("status", "feedback_message")
_AT_THE_PLACE = ("lower", "release", "rise")


def scene_view(
    truth: Truth | None,
    fixtures: Sequence[Geom] = (),
    nodes: Sequence[TreeNode] = (),
    *,
    estimated: bool = False,
) -> SceneView:
    """The shapes of a world (of `fixtures` without one), and the places that a tree names.

    `estimated` is whether the robot has to estimate where it is on the map.
    """
    given = [value for n in nodes for value in getattr(n.node, "given", {}).values()]
    named = {
        value.name: value for value in given if isinstance(value, Region | ToolPose | BasePose)
    }
    goals = {
        name: value.mTe if isinstance(value, ToolPose) else value.mTb
        for name, value in named.items()
        if not isinstance(value, Region)
    }
    objects = _movable(truth) if truth else ()
    return SceneView(
        fixtures=tuple(truth.fixtures if truth else fixtures),
        objects=tuple((one.name, one.parts) for one in objects),
        regions=tuple(value for value in named.values() if isinstance(value, Region)),
        goals=tuple(goals.items()),
        estimated=estimated,
    )


def recorded_scene(options: Mapping[str, Any], robot: RobotDescription) -> SceneView:
    """The shapes of a finished run's world by its options, recomputed from scene and seed.

    Raises UserError: the scene is missing or has a mistake.
    """
    from hw.sim import load_fixtures, load_localisation, load_scene

    if options["scene"] is None or options["world"] == "hardware":
        site = options["map"]
        return SceneView(fixtures=load_fixtures(site) if site else ())
    level = load_localisation(options["localisation"] or DEFAULT_LEVEL)
    footprint = robot.base.size[:2]
    return scene_view(load_scene(options["scene"], options["seed"], footprint, level.moved))


def _movable(truth: Truth) -> tuple[TrueObject, ...]:
    return (*truth.objects, *truth.walkers)


def phases_of(leaf: Leaf) -> tuple[str, ...]:
    """What a running leaf does: its key and, if it has phases, that one.

    A `navigate` with something in the hand is `carry`, a `retreat_check` also `retreat`.
    """
    if leaf.key == "navigate" and not (leaf.gripper_is_open or leaf.gripper_is_closed):
        return ("carry",)
    if leaf.key == "retreat_check":
        return (leaf.key, "retreat")
    if not leaf.phase or (leaf.key == "place" and leaf.phase not in _AT_THE_PLACE):
        return (leaf.key,)  # the approach of a place is not that of a grasp
    return (leaf.key, leaf.phase)


def current_phases(nodes: Iterable[Behaviour]) -> frozenset[str]:
    """The phases of the leaves that run."""
    running = (one for one in nodes if one.status is Status.RUNNING and isinstance(one, Leaf))
    return frozenset(phase for leaf in running for phase in phases_of(leaf))


class Snapshots:
    """Makes the snapshots of one run."""

    def __init__(self, nodes: Sequence[TreeNode], truth: Truth | None) -> None:
        self._nodes = [place.node for place in nodes]
        self._leaves = [node for node in self._nodes if isinstance(node, Leaf)]
        never = NodeStatus(Status.INVALID, "")
        self._statuses: tuple[NodeStatus, ...] = (never,) * len(nodes)
        self._truth = truth
        self._movable = _movable(truth) if truth else ()
        self._shown: DepthFrame | None = None
        self.began: TaskTime | None = None  # time of the first tick

    def of(self, tick: Tick, paused: str = "") -> Snapshot:
        """The snapshot of a tick, on the map; a frame is in that of the tick that first used it.

        `paused` is why the run is paused, if it is.
        """
        context, vision = tick.context, tick.context.vision
        clock = context.clock
        self.began = self.began or clock.now()
        is_new = vision.frame is not self._shown
        self._shown = vision.frame
        here = context.localisation
        frame, grasp = vision.frame if is_new else None, vision.grasp
        nodes, before, log = self._of_nodes(), self._statuses, context.log
        changed = [one.status for one in nodes] != [one.status for one in before]
        self._statuses = nodes
        return Snapshot(
            tick=tick.number,
            time=clock.now().since(self.began),
            paused_s=clock.paused_s,
            state=tick.state,
            command=tick.applied,
            report=tick.report,
            seconds=tick.seconds,
            nodes=nodes,
            changed=changed,
            phases=current_phases(self._leaves),
            paused=paused,
            too_slow=tick.too_slow,
            attempts=log.attempts,
            placed=log.placed,
            holds=log.in_hand is not None,
            goal=tick.goal,
            estimate=self._estimate(here),
            objects=tuple([one.pose for one in self._movable]),
            frame=frame,
            pictures=self._pictures(log),
            detection=vision.detection if is_new else None,
            grasp=grasp,
            locked=vision.tracker.locked,
            seen=context.around.points(context.localisation),
        )

    def _estimate(self, here: Localiser) -> PoseEstimate | None:
        if (estimate := here.estimate) is None or here.mTo is None:
            return None
        true_base = None if self._truth is None else self._truth.base
        return PoseEstimate(*estimate, here.mTo, here.registration, here.scan, true_base)

    def _pictures(self, log: TaskLog) -> tuple[tuple[str, DepthFrame], ...]:
        kept, log.pictures = tuple(log.pictures), []
        return kept

    def _of_nodes(self) -> tuple[NodeStatus, ...]:
        """Statuses of the nodes; an unchanged one stays the same object."""
        now: tuple[Any, ...] = tuple(map(_STATUS, self._nodes))
        if now == self._statuses:
            return self._statuses
        kept = zip(self._statuses, now, strict=True)
        return tuple([old if old == new else NodeStatus(*new) for old, new in kept])
