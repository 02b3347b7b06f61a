"""What holds for every test."""

from __future__ import annotations

import gc
import itertools
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

LIMITS = {False: 120.0, True: 600.0}
"""Of a test, and of a slow one [s]: one that hangs fails, and the others go on.

Measured by a thread, as `hw.loop_watchdog` has the alarm signal to itself.
"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A test that hangs fails; one that is marked `realtime` has three attempts.

    A computer that stands still for 20 ms makes an emulated robot stop, as it should: that says
    nothing about the driver. A driver that is wrong is wrong three times.
    """
    for item in items:
        limit = LIMITS[item.get_closest_marker("slow") is not None]
        item.add_marker(pytest.mark.timeout(limit, method="thread"))
        if item.get_closest_marker("realtime") is not None:
            item.add_marker(pytest.mark.flaky(reruns=2))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Each rerun, and what caused it."""
    reruns = terminalreporter.getreports("rerun")
    if reruns:
        terminalreporter.section(f"{len(reruns)} reruns")
    for report in reruns:
        crash = getattr(report.longrepr, "reprcrash", None)
        said = str(crash.message if crash else report.longrepr).strip().splitlines()
        terminalreporter.line(f"{report.nodeid}: {said[0] if said else report.when}")


MAY_SKIP = ("this computer is too slow", "the index of packages cannot be reached")
"""Reasons of the skips that continuous integration accepts: what it has not."""


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where `CI` is set, a test that is skipped for another reason than those fails the run."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if "CI" not in os.environ or hasattr(session.config, "workerinput") or reporter is None:
        return
    said = [report.longrepr[2] for report in reporter.getreports("skipped")]
    if [one for one in said if not any(reason in one for reason in MAY_SKIP)]:
        reporter.line("tests were skipped that CI is to run", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_collection_finish() -> None:
    """No collection of garbage looks through the modules of all tests again, half of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def same_priority() -> Iterator[None]:
    """No test leaves this process before all others: robots emulated for the next would be late.

    Libraries of real-time robots raise the priority of whoever calls them, and leave it so.
    """
    if not hasattr(os, "sched_getscheduler"):
        yield
        return
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    yield
    if (os.sched_getscheduler(0), os.sched_getparam(0)) != (policy, priority):
        os.sched_setscheduler(0, policy, priority)


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C raises, also where a shell in the background has had it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


NUMBERS = itertools.count()


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Installs a package with one module, as the metadata of pip describe it.

    Called with the source, the group of the entry point, its name, and its object in the module.
    """
    from perception import known_classes
    from trees.language import known_leaves, registry

    def forget() -> None:
        registry.offer_of.cache_clear()
        known_classes.cache_clear()
        known_leaves()

    def install(source: str, group: str, name: str, offered: str) -> None:
        module = f"package_{next(NUMBERS)}"  # one whose import hangs blocks its name for ever
        info = home / f"{module}-1.0.dist-info"
        info.mkdir()
        (home / f"{module}.py").write_text(source)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
        entry = f"[frankie_task.{group}]\n{name} = {module}:{offered}\n"
        (info / "entry_points.txt").write_text(entry)
        known_classes.cache_clear()

    home = tmp_path / "site"
    home.mkdir()
    monkeypatch.syspath_prepend(str(home))
    monkeypatch.setattr(registry, "IMPORT_TIMEOUT", 1.0)
    forget()
    yield install
    monkeypatch.undo()
    forget()
