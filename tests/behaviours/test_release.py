"""Thresholds of a release and of a retreat: the fingers, the way up, and the last look."""

import numpy as np
import pytest
from pinocchio import SE3, exp3
from py_trees.common import Status
from scripted import FRANKIE, HERE, Script, up

from behaviours.core.placed_object import Verdict
from behaviours.release import Release, Spot, release_height
from behaviours.retreat_check import RetreatCheck
from behaviours.wait import Wait
from controller import BaseGoal, PoseGoal
from robots import half_extents

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
ABOVE = 0.12


class Releasing:
    """A leaf that lets go of what is 40 mm wide; the hand is to rise by 0.12 m."""

    def __init__(self, room: float | None = None, rises: float = ABOVE, backs_off=False) -> None:
        self.script = Script()
        self.script.holds()
        self.context, self.used = self.script.context, []
        self.context.log.grip_opening = room
        self.leaf = Wait("leaf", self.context, duration_s=1.0)
        spot = Spot("spot", np.array([0.7, 0.0, 0.5]), 0.06, np.zeros(400))
        goal = PoseGoal(target=HERE, base_rests=True)
        self.release = Release(
            self.leaf,
            goal,
            spot=spot,
            up=rises,
            backs_off=backs_off,
            used=lambda: self.used.append(1),
        )

    def tick(self, away: float | None = 0.1, **reading) -> Status:
        """One tick, and what the controller says of its goal."""
        self.script.reads(**reading)
        status = self.release.tick()
        if away is not None:
            self.script.report(away)
        return status

    def opened(self, width: float = 0.08) -> "Releasing":
        """The fingers have opened."""
        self.tick(width=0.04, gripper_moving=True)
        self.tick(width=width, gripper_moving=True)
        self.tick(gripper_moving=False)
        self.tick()
        return self

    def risen(self, by: float, verdict: Verdict, **reading) -> Status:
        """The hand is so high, and the camera has told that."""
        if self.context.memory.placed_object is not None:
            self.context.memory.placed_object.verdict = verdict
        return self.tick(hand=up(by), **reading)

    @property
    def goes_up(self) -> float:
        """How much higher than the place of the release the goal is, straight above it [m]."""
        x, y, z = self.script.goal.target.translation - HERE.translation
        assert (x, y) == (0.0, 0.0)
        return float(z)


@pytest.mark.parametrize(
    ("room", "opens_to", "by"), [(None, 0.08, 0.02), (0.045, 0.05, 0.0075), (0.06, 0.06, 0.017)]
)
def test_it_is_let_go_once_the_fingers_have_opened_enough(room, opens_to, by):
    """By 2 cm, or as far as they open beside what stands there: 1 cm more than it is wide."""
    one = Releasing(room)
    assert one.script.grips == [pytest.approx(opens_to)]
    one.tick(width=0.04 + by - 0.0005, gripper_moving=True)
    assert (one.used, one.release.phase) == ([], "release")
    assert one.context.log.in_hand is not None
    assert one.goes_up == 0.0
    assert one.script.goal.base_rests
    one.tick(width=0.04 + by + 0.0005, gripper_moving=True)
    assert one.used == [1]
    assert one.context.log.in_hand is None
    (shape,) = one.context.memory.set_down.shapes
    np.testing.assert_allclose(shape.pose.translation[:2], HERE.translation[:2], atol=1e-6)
    assert one.tick() is RUNNING
    assert one.release.phase == "rise"


def test_the_fingers_open_fully_once_the_hand_is_clear():
    one = Releasing(0.06).opened(0.06)
    for by, grips in ((0.0395, 1), (0.0405, 2), (0.05, 2)):
        one.risen(by, Verdict.UNSEEN)
        assert len(one.script.grips) == grips
    assert one.script.grips[-1] == FRANKIE.gripper.opening
    one = Releasing().opened()
    one.risen(0.05, Verdict.UNSEEN)
    assert len(one.script.grips) == 1  # they are open


@pytest.mark.parametrize(("rises", "enough"), [(0.12, 0.09), (0.06, 0.04)])
def test_the_hand_rises_until_it_is_up_and_the_object_was_seen(rises, enough):
    one = Releasing(rises=rises).opened()
    goal = one.script.goal
    assert one.goes_up == pytest.approx(rises + 0.12)
    assert (goal.hand_may_touch, goal.base_rests, goal.speed) == (True, False, 0.5)
    assert one.risen(enough - 0.001, Verdict.STANDS) is RUNNING
    assert one.leaf.feedback_message.startswith("rising, 0.0")
    assert one.risen(enough + 0.001, Verdict.UNSEEN) is RUNNING
    assert one.leaf.feedback_message.startswith("rising, 0.0")
    assert one.risen(enough + 0.001, Verdict.STANDS) is RUNNING
    assert one.leaf.feedback_message == "looking once more"


@pytest.mark.parametrize(
    ("shown", "empty", "waits"), [(-1.0, 0, 0.25), (-1.0, 1, 9.0), (0.0, 0, 0.0), (0.0, 1, 0.0)]
)
def test_a_frame_is_awaited_that_shows_it_once_the_hand_is_up(shown, empty, waits):
    one = Releasing().opened()
    watch = one.context.memory.placed_object
    watch.shown, watch.empty = np.inf, empty  # seen since, if it is not said otherwise
    if shown < 0.0:
        watch.shown = one.script.clock.now()
    status = one.risen(0.11, Verdict.STANDS)
    assert status is (RUNNING if waits else SUCCESS)
    if waits > 1.0:
        assert one.tick(after=0.5) is RUNNING
        return
    if waits:
        assert one.tick(after=waits - 0.005) is RUNNING
        assert one.goes_up == pytest.approx(ABOVE + 0.12)
        assert one.tick(after=0.01) is SUCCESS
    assert one.leaf.feedback_message == "it stands at spot"


def test_what_is_gone_is_forgotten_and_was_not_placed():
    one = Releasing().opened()
    carried = one.context.log.carried[-1]
    assert one.risen(0.11, Verdict.GONE) is FAILURE
    assert one.leaf.feedback_message == "let go, but nothing stands at spot"
    assert one.context.memory.set_down.shapes == ()
    assert (one.context.memory.placed_object, carried.placed) == (None, None)


def test_the_hand_sways_until_it_is_seen_or_the_camera_has_lost_its_patience():
    """Each way takes 0.6 s, by 6 cm; all of it 2 s."""
    one = Releasing().opened()
    heights, begun = [], None
    status = one.tick(away=0.0, hand=up(0.24))
    while status is RUNNING:
        status, now = one.tick(away=0.0, after=0.0995), one.script.clock.now()
        if one.leaf.feedback_message.startswith("looking"):
            begun = begun or now
            heights.append((now - begun, one.goes_up))
    assert one.leaf.feedback_message == (
        "let go, but it is not seen whether it stands at spot: no camera frame"
    )
    assert heights[-1][0] == pytest.approx(1.95, abs=0.1)
    for at, high in heights:
        assert high == pytest.approx(0.18 if at % 1.2 < 0.6 else 0.24), at


def test_a_hand_that_is_stuck_on_the_way_up_has_placed_nothing():
    """It goes straight: on a detour it would have 12 s."""
    one = Releasing().opened()
    begun, moving = one.script.clock.now(), np.full(7, 0.1)
    while one.tick(after=0.1, hand=None, qd=moving) is RUNNING:
        assert one.script.clock.now() - begun < 4.0
    assert one.leaf.feedback_message == "rising: stuck 0.00 m up"


def test_a_hand_that_can_rise_no_more_has_to_see_it_from_there():
    one = Releasing().opened()
    one.risen(0.11, Verdict.UNSEEN)
    while one.tick(after=0.1) is RUNNING and not one.leaf.feedback_message.startswith("looking"):
        assert one.script.clock.now() < 8.0
    one.context.memory.placed_object.shown = np.inf
    assert one.risen(0.11, Verdict.STANDS) is SUCCESS


def test_fingers_that_stop_half_way_have_not_let_go():
    one = Releasing()
    one.tick(width=0.055, gripper_moving=True)
    assert one.tick(width=0.055, gripper_moving=False) is FAILURE
    assert one.leaf.feedback_message == "not let go: the fingers stopped at 55 mm"


def test_the_base_backs_off_from_what_is_high():
    one = Releasing(backs_off=True).opened()
    one.context.memory.placed_object.shown = np.inf
    assert one.risen(0.11, Verdict.STANDS) is RUNNING
    assert one.leaf.feedback_message == "backing off"
    goal = one.script.goal
    assert isinstance(goal, BaseGoal)
    assert one.tick() is RUNNING
    assert one.script.goal is goal  # not from where it is by then
    one.script.report(0.0)
    assert one.tick() is SUCCESS


def test_finger_tips_stay_four_millimetres_above_the_surface_with_the_largest_tilt():
    script = Script()
    for height, reaches in ((0.03, 0.03), (-0.02, FRANKIE.gripper.tip)):
        script.context.log.grip_height = height
        pad = FRANKIE.gripper.pad
        outer = FRANKIE.gripper.opening / 2.0 + pad.pose.translation[1]
        outer += half_extents(pad.shape)[1]
        corner = np.array([0.0, outer, reaches])
        tilted = HERE.rotation @ exp3(np.array([np.radians(2.0), 0.0, 0.0]))
        lowest = (SE3(tilted, np.zeros(3)).act(corner))[2] + release_height(script.context)
        assert lowest == pytest.approx(0.004, abs=2e-4)


def retreating(width: float = 0.04) -> tuple[Script, RetreatCheck]:
    script = Script()
    script.holds(width)
    script.rest(s=0.3)
    leaf = RetreatCheck("retreat_check", script.context)
    leaf.tick_once()
    assert leaf.status is RUNNING
    script.report(0.2)
    return script, leaf


def asked(script: Script, leaf: RetreatCheck, away: float = 0.2, **reading) -> tuple[Status, str]:
    script.reads(**reading)
    leaf.tick_once()
    script.report(away)
    return leaf.status, leaf.feedback_message


def test_a_hand_that_is_up_holds_what_its_fingers_rest_on():
    script, leaf = retreating()
    assert script.goal.target.translation[2] == pytest.approx(HERE.translation[2] + 0.2)
    assert script.goal.speed == 0.5
    assert asked(script, leaf, 0.031)[0] is RUNNING
    assert asked(script, leaf, 0.029) == (RUNNING, "rising, 40 mm between the fingers")
    assert asked(script, leaf) == (SUCCESS, "holding something 40 mm wide")


def until_it_ends(script: Script, leaf: RetreatCheck, **reading) -> tuple[float, str]:
    """How long that took [s], and what it says."""
    begun = script.clock.now()
    while asked(script, leaf, after=0.1, **reading)[0] is RUNNING:
        assert script.clock.now() - begun < 20.0
    return script.clock.now() - begun, leaf.feedback_message


def test_a_hand_that_is_stuck_below_has_missed():
    """It goes straight: on a detour it would have 12 s."""
    s, said = until_it_ends(*retreating(), qd=np.full(7, 0.1))
    assert said == "stuck 0.20 m below the retreat"
    assert s == pytest.approx(2.1, abs=0.11)


def test_fingers_that_still_close_are_waited_for():
    script, leaf = retreating()
    asked(script, leaf, 0.0, width=0.039, gripper_moving=True)
    assert asked(script, leaf, 0.0) == (RUNNING, "the fingers are slipping off")
    s, said = until_it_ends(script, leaf, away=0.0)
    assert said == "the fingers still move after 3 s"
    assert s == pytest.approx(3.0, abs=0.11)


def test_what_was_missed_is_not_blamed_on_a_hand_that_was_not_told_to_close():
    script = Script()
    leaf = RetreatCheck("retreat_check", script.context)
    script.reads(width=0.04)
    leaf.tick_once()
    assert leaf.feedback_message == "the fingers were not told to close"


def test_fingers_on_nothing_have_missed_though_they_move():
    script, leaf = retreating()
    rejected = []
    script.context.vision.tracker.reject = rejected.append
    assert asked(script, leaf, width=0.001, gripper_moving=True)[0] is FAILURE
    assert (leaf.feedback_message, rejected) == ("the fingers closed on nothing", [HERE])
    script, leaf = retreating()
    status, text = asked(script, leaf, width=0.03, gripper_moving=True)
    assert (status, text) == (RUNNING, "rising, 30 mm between the fingers")
