"""Clocks: simulated, paced and real time, and task time with pauses."""

import pytest

from hw import SimClock, TaskClock, TaskTime


def test_simulated_time_jumps_and_never_goes_back():
    clock = SimClock()
    clock.sleep_until(3600.0)
    clock.sleep_until(10.0)
    assert clock.now() == 3600.0


def test_task_time_is_never_compared_with_session_time():
    session = SimClock()
    task = TaskClock(session)
    start = task.now()
    session.sleep_until(2.0)
    assert task.now() - start == 2.0
    assert task.now() > start
    assert start + 2.0 == task.now()
    for operation in (
        lambda: task.now() > session.now(),
        lambda: task.now() - session.now(),
        lambda: session.now() - task.now(),
    ):
        with pytest.raises((TypeError, AttributeError)):
            operation()
    assert task.now() != session.now()


@pytest.mark.parametrize("pace", [1.0, 0.1])
def test_task_time_goes_at_its_pace_and_without_pauses(pace):
    session = SimClock()
    task = TaskClock(session, pace=pace)
    start = task.now()
    session.sleep_until(20.0)
    assert task.now() - start == pytest.approx(20.0 * pace)
    assert (start + 20.0 * pace).seconds == pytest.approx(20.0)
    task.hold()
    session.sleep_until(50.0)
    assert task.now() == TaskTime(20.0, pace)
    task.release()
    session.sleep_until(51.0)
    assert task.now() - start == pytest.approx(21.0 * pace)
