"""Drivers of installed packages, good and broken: what robot files and `drivers` say of them."""

from __future__ import annotations

import itertools

import pytest
from command_line import call

from config import ConfigError
from robots import load_robot
from robots.load import SHIPPED

NUMBERS = itertools.count()
DRIVER = """\
from frankie_task import DriverOptions

class Options(DriverOptions):
    address: str
    speed: float = 0.5

def mine(options: Options, context):
    return None
"""
BROKEN = {
    "lacks a module": ("import no_such_module\n", "No module named 'no_such_module'"),
    "exits": ("raise SystemExit\n", "SystemExit"),
    "has no options": ("def mine(options, context): ...\n", "is not annotated with"),
    "is no function": ("mine = 1\n", "it is no function or class"),
}


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Installs a package that offers a base, as the metadata of pip describe it."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(source: str) -> None:
        module = f"driver_{next(NUMBERS)}"
        (tmp_path / f"{module}.py").write_text(source)
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
        offer = f"[frankie_task.drivers]\nbase.mine = {module}:mine\n"
        (info / "entry_points.txt").write_text(offer)

    return install


@pytest.fixture
def file(tmp_path):
    """The template with another base."""
    text = (SHIPPED / "frankie_site.yaml").read_text()
    begin, end = text.index("    driver: omron"), text.index("  arm:\n")
    path = tmp_path / "ours.yaml"
    path.write_text(f"{text[:begin]}    driver: mine\n    address: 10.0.0.1\n{text[end:]}")
    return path


def test_options_are_validated_by_the_model_of_the_driver(install, file):
    install(DRIVER)
    load_robot(file)
    file.write_text(file.read_text().replace("    address: 10.0.0.1", "    adress: 10.0.0.1"))
    with pytest.raises(ConfigError, match=r"11:5: hardware\.base\.adress: unknown .* `address`"):
        load_robot(file)
    out = call("drivers")[1]
    assert "address, speed=0.5" in out
    assert "panda" in out


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_driver_hinders_only_the_robots_that_use_it(install, file, kind):
    source, told = BROKEN[kind]
    install(source)
    with pytest.raises(ConfigError) as refused:
        load_robot(file)
    (line,) = str(refused.value).splitlines()
    assert "10:13: hardware.base.driver: the driver `base.mine` of `driver_" in line
    assert told in line
    load_robot("frankie_site")
    code, out, err = call("drivers")
    assert code == 0
    assert "omron" in out
    assert err.startswith("warning: ")


def test_two_packages_with_one_name_are_both_told(install, file):
    install(DRIVER)
    install(DRIVER)
    with pytest.raises(ConfigError, match=r"is offered by driver_\d+ 1.0 and driver_\d+ 1.0"):
        load_robot(file)
