"""Drivers of installed packages, good and broken: what robot files and `drivers` say of them."""

import pytest
from command_line import call

from config.reader import ConfigError
from robots import load_robot
from robots.load import SHIPPED

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
def install_base(install):
    return lambda source: install(source, "drivers", "base.mine", "mine")


@pytest.fixture
def file(tmp_path):
    """The template with another base."""
    text = (SHIPPED / "frankie_site.yaml").read_text()
    begin, end = text.index("    driver: omron"), text.index("  arm:\n")
    path = tmp_path / "ours.yaml"
    path.write_text(f"{text[:begin]}    driver: mine\n    address: 10.0.0.1\n{text[end:]}")
    return path


def test_options_are_validated_by_the_model_of_the_driver(install_base, file):
    install_base(DRIVER)
    load_robot(file)
    file.write_text(file.read_text().replace("    address: 10.0.0.1", "    adress: 10.0.0.1"))
    with pytest.raises(ConfigError, match=r"11:5: hardware\.base\.adress: unknown .* `address`"):
        load_robot(file)
    out = call("drivers")[1]
    assert "address, speed=0.5" in out
    assert "panda" in out


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_driver_hinders_only_the_robots_that_use_it(install_base, file, kind):
    source, told = BROKEN[kind]
    install_base(source)
    with pytest.raises(ConfigError) as refused:
        load_robot(file)
    (line,) = str(refused.value).splitlines()
    assert "10:13: hardware.base.driver: the driver `base.mine` of package_" in line
    assert told in line
    load_robot("frankie_site")
    code, out, err = call("drivers")
    assert code == 0
    assert "omron" in out
    assert err.startswith("warning: ")


def test_two_packages_with_one_name_are_both_told(install_base, file):
    install_base(DRIVER)
    install_base(DRIVER)
    with pytest.raises(ConfigError, match=r"is offered by package_\d+ 1.0 and package_\d+ 1.0"):
        load_robot(file)
