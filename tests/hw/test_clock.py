"""Clocks: simulated, paced and real time, and task time with pauses."""

from threading import Event

import pytest

from hw import SimClock, TaskClock, TaskTime, Worker


def test_simulated_time_jumps_and_never_goes_back():
    clock = SimClock()
    clock.sleep_until(3600.0)
    clock.sleep_until(10.0)
    assert clock.now() == 3600.0


def test_work_in_a_thread_is_done_when_simulated_time_says_so_whatever_it_takes():
    clock, quick, slow = SimClock(), Event(), Event()
    worker = Worker(clock, 0.03)
    first, second = worker.submit(quick.set), worker.submit(slow.wait, 60.0)
    assert quick.wait(60.0)
    clock.sleep_until(0.02)
    assert not first.done()
    slow.set()
    failed = worker.submit(int, "no number")
    clock.sleep_until(0.03)
    assert first.done()
    assert second.result(0.0)
    assert not failed.done()
    clock.sleep_until(0.05)
    assert isinstance(failed.exception(0.0), ValueError)
    worker.shutdown()


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
