"""Corrections of where the map is: no command jumps, and what is locked stays where it is."""

from dataclasses import replace

import numpy as np
import pytest
from harness import ByHand, Harness, looking_down, table_world
from pinocchio import SE3, utils
from synthetic_room import LASER_AT, MAP, SURFACES, Robot

from behaviours import ToolPose
from behaviours.sensing.localiser import EstimatedLocaliser
from behaviours.sensing.map_matching import MapMatching, MapSensors
from config.planar import in_space, on_floor
from controller import PoseGoal
from hw import LaserScan
from hw.state import LocalisedPose


class Corrected:
    """The harness with a base that is localised wrongly, and differently all the time."""

    def __init__(self, size: float, every: int = 1, seed: int = 0) -> None:
        self.harness = harness = Harness(table_world())
        self._every, self._rng = every, np.random.default_rng(seed)
        self._sigma = np.array([size / 2.0, size / 2.0, 0.4 * size]) + 1e-6
        self.corrections = self._ticks = 0
        self._newest: LocalisedPose | None = None
        self._read, harness.robot.read = harness.robot.read, self._wrong

    def _wrong(self):
        state = self._read()
        if self._ticks % self._every == 0:
            x, y, turn = self._sigma * self._rng.normal(size=3)
            self._newest = LocalisedPose(
                stamp=state.stamp,
                mTb=state.oTb * SE3(utils.rotate("z", turn), np.array([x, y, 0.0])),
                covariance=np.diag(self._sigma) ** 2,
            )
            self.corrections += 1
        self._ticks += 1
        return replace(state, localised=self._newest)


def test_no_correction_makes_a_command_jump():
    """To goals of both kinds in turn; the gate refuses what no limit allows."""
    run = Corrected(0.1)
    harness, context = run.harness, run.harness.context
    places = [
        ToolPose(name="there", mTe=looking_down(0.6, 0.3, 0.8), frame=context),
        ToolPose(name="far", mTe=looking_down(-1.5, 1.0, 0.8), frame=context),
    ]
    moved = 0.0
    while run.corrections < 400:
        before = context.localisation.mTb
        place = places[(run.corrections // 200) % 2]
        state = harness.robot.read()
        context.begin_tick(state)
        step = context.localisation.mTb.translation - before.translation
        moved = max(moved, float(np.linalg.norm(step)))
        harness.step(state, PoseGoal(target=place.oTe))
    assert not any(harness.gate.refusals.values())
    assert moved > 0.001


def test_a_locked_pose_is_reached_as_if_nothing_had_been_corrected():
    ends = []
    for size in (0.0, 0.1):
        run = Corrected(size, every=20)
        harness = run.harness
        goal = PoseGoal(target=looking_down(0.7, 0.1, 0.7), straight=True)
        for _ in range(400):
            harness.pursue(goal)
        ends.append(harness.context.oTe)
    assert np.linalg.norm(ends[0].translation - ends[1].translation) < 0.003
    assert np.linalg.norm(ends[1].translation - goal.target.translation) < 0.003


def test_where_nothing_is_localised_the_map_is_the_world():
    harness = Harness(table_world())
    harness.tick(None)
    here = harness.context.localisation
    assert here.mTo is None
    assert here.estimate is None
    place = ToolPose(name="there", mTe=looking_down(1.0, 0.0, 0.8), frame=here)
    assert place.oTe is place.mTe


class InARoom:
    """A base that stands in a room whose laser is registered to the map when the test says so."""

    def __init__(self, oTb: SE3 | None = None, error: float = 0.0) -> None:
        harness = Harness(table_world())
        self._state, self._robot = harness.context.state, Robot(np.random.default_rng(0))
        self._work, self.scan, self.now = ByHand(), None, 0.0
        self.stands_at, self.oTb = np.zeros(3), oTb or SE3.Identity()
        self._error = np.array([error, 0.0, 0.0])
        sensors = MapSensors(SURFACES, ("laser",), self._work)
        description, vision = harness.robot.description, harness.context.vision
        matching = MapMatching(sensors, description, vision, lambda: self.scan)
        self.localiser = EstimatedLocaliser(self._reading(), matching)

    def _reading(self):
        """Its wheels notice nothing; its own localisation does, as if it were carried."""
        covariance = np.diag([0.02, 0.02, 0.01]) ** 2
        there = in_space(self.stands_at + self._error)
        pose = LocalisedPose(stamp=self.now, mTb=there, covariance=covariance)
        return replace(self._state, stamp=self.now, oTb=self.oTb, localised=pose)

    def _sees(self) -> None:
        """A scan from where it stands now; its registration begins."""
        points = self._robot.scan(MAP, self.stands_at).points
        ranges = np.linalg.norm(points - LASER_AT, axis=1)
        self.scan = LaserScan(stamp=self.now, ranges=ranges, points=points, oTb=SE3.Identity())

    def reads(self, after: float = 0.1, *, localised: bool = True) -> None:
        """The next reading, so much later [s]."""
        self.now += after
        state = self._reading()
        self.localiser.read(state if localised else replace(state, localised=None))

    def looks(self) -> None:
        """What it saw was registered; it sees anew if nothing is being registered."""
        if self._work.waiting:
            self._work.work()
        else:
            self._sees()
        self.localiser.look()


def test_what_was_registered_confirms_the_estimate_as_of_its_scan():
    base = InARoom()
    base.reads()
    base.looks()
    scanned = base.scan.stamp
    assert base.localiser.confirmed == -np.inf
    base.reads(0.5, localised=False)
    base.looks()
    assert base.localiser.registrations == 1
    assert base.localiser.confirmed == base.localiser.agreement.last == scanned < base.now
    base.reads()
    assert base.localiser.confirmed == base.now


def test_a_map_that_jumps_does_so_in_the_next_reading_and_is_confirmed_by_the_scan_that_told():
    base = InARoom()
    for _ in range(10):
        base.reads()
        base.looks()
    here, base.stands_at = base.localiser, np.array([0.5, 0.2, 0.0])
    for _ in range(30):
        base.reads()
        base.looks()
        if here.relocalised:
            break
    assert here.relocalised.startswith("the base was relocalised by 0.5")
    assert here.confirmed == base.scan.stamp > base.now - 0.15
    assert on_floor(here.mTb) == pytest.approx(np.zeros(3), abs=0.02)  # as in all of this tick
    base.reads()
    assert not here.relocalised
    assert on_floor(here.mTb) == pytest.approx(base.stands_at, abs=0.03)


@pytest.mark.parametrize(
    ("metres", "turn", "moves"),
    [(0.0019, 0.0019, False), (0.0021, 0.0, True), (0.0, 0.0021, True)],
)
def test_the_map_follows_at_once_until_the_base_moves(metres, turn, moves):
    """Where its heading goes past half a turn, too."""
    base = InARoom(in_space((0.0, 0.0, np.pi - 1e-4)), error=0.02)
    base.reads()
    base.looks()
    base.oTb = in_space((metres, 0.0, np.pi - 1e-4 + turn))
    base.reads()
    base.looks()  # the laser corrects the error
    base.reads(0.001)
    assert base.localiser.registrations == 1
    assert (base.localiser.pending > 0.01) is moves
