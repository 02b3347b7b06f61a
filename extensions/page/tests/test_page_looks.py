"""The page on four screens: Stop in sight, nothing cut off, readable for all, and quick."""

from dataclasses import replace

import pytest
from browsers import chromium, opened_page
from sample_run import SCENE, TREE, moment

from app.live import Control, RunInfo
from app.live.nodes import NodeInfo
from extensions.page.control_page import ControlPage
from extensions.page.plan import Plan
from extensions.page.server import PageServer
from hw import Fault, FaultKind

pytestmark = pytest.mark.slow

SCREENS = [(1600, 900), (1280, 720), (820, 1180), (390, 844), (360, 640)]
FAULT = Fault(kind=FaultKind.EMERGENCY_STOP, text="emergency stop", clearable=False)
INFO = RunInfo(
    task="sort", where="frankie · omron 10.10.10.10 · panda 172.16.0.2", objects=10, real=True
)


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture
def address():
    with PageServer() as server:
        plan, control = Plan(SCENE, (0.7, 0.5)), Control()
        control.emergency_stop(FAULT.text, pressed=False)
        page = ControlPage(control, TREE, info=INFO, plan=plan, may_force=True)
        server.serve(page)
        for tick in (0, 60, 180):
            page.show(moment(tick))
        last = moment(181)
        last.state = replace(last.state, faults=(FAULT,))
        page.show(last)
        yield server.url


@pytest.mark.parametrize(("width", "height"), SCREENS)
def test_stop_is_in_sight_and_nothing_is_cut_off(browser, address, width, height):
    page = opened_page(browser, address, width=width, height=height)
    assert page.inner_text("#world") == f"ARMED · {INFO.where}"
    for tab in page.locator("[role=tab]").all():
        if tab.is_visible():
            tab.click()
        box = page.locator("#stop").bounding_box()
        assert box["height"] >= 64.0
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= width
        assert 0.0 <= box["y"] <= height - box["height"]
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_serious_fault(browser, address, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    context = browser.new_context(
        color_scheme=scheme, viewport={"width": 390, "height": 844}, bypass_csp=True
    )
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector(".row", state="attached")
    for tab in ("robot", "tree", "log"):
        page.click(f"#tab-{tab}")
        found = axe.run(page).response["violations"]
        grave = [one for one in found if one["impact"] in ("serious", "critical")]
        assert [(one["id"], [n["html"] for n in one["nodes"]][:3]) for one in grave] == []
    context.close()


def test_three_hundred_nodes_are_drawn_and_the_first_paint_is_light(browser):
    nodes = [NodeInfo(name=f"node {i}", kind="sequence", depth=i % 12) for i in range(300)]
    with PageServer() as server:
        page = ControlPage(Control(), nodes)
        server.serve(page)
        shown = moment(180)
        statuses = tuple(shown.nodes[i % 12] for i in range(300))
        shown.nodes = statuses
        page.show(shown)
        tab = browser.new_page()
        sizes = []
        tab.on("response", lambda reply: sizes.append(int(reply.headers.get("content-length", 0))))
        tab.goto(server.url)
        tab.wait_for_selector(".row")
        assert sum(sizes) < 100_000
        assert tab.locator(".row").count() == len(nodes)
        tab.close()
