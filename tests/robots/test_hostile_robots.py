"""Robot files with an impossible number: refused with its place, or a robot that is sound."""

import shutil
from pathlib import Path

import pytest

from config import ConfigError
from robots import load_robot
from robots.load import SHIPPED


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(SHIPPED, tmp_path / "robots", ignore=shutil.ignore_patterns("*.py"))
    return tmp_path / "robots"


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "/dev/zero", "/proc/self/mem", "/", ""])
def test_a_robot_that_is_no_file_is_refused(name):
    with pytest.raises(ConfigError, match=r"no robot is called|cannot be read"):
        load_robot(name)


def test_a_part_that_is_no_file_is_refused(folder):
    path = folder / "frankie.yaml"
    good = path.read_text()
    for part in ("x" * 5000, '"a\\0b"', "/dev/zero", "..", "/etc/passwd"):
        path.write_text(good.replace("arm: panda", f"arm: {part}"))
        with pytest.raises(ConfigError) as error:
            load_robot(path)
        assert "\n" not in str(error.value) or part == "/etc/passwd"
