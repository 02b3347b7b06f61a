"""Robot files with an impossible number: refused with its place, or a robot that is sound."""

import random
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from config import ConfigError
from robots import load_robot
from robots.load import SHIPPED

ODD = (".nan", ".inf", "-.inf", "-1", "0", "1e300", "-1e300", "1e-300", "1e999", "9" * 400, "many",
       "null", "true", "[]", "{}", "[[[[1]]]]", "!!float 1", "*a", '"\\e[2J"')  # fmt: skip
NUMBER = re.compile(r"-?\d+\.?\d*")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(SHIPPED, tmp_path / "robots", ignore=shutil.ignore_patterns("*.py"))
    return tmp_path / "robots"


@pytest.mark.parametrize(
    "file", ["frankie.yaml", "parts/panda.yaml", "parts/franka_hand.yaml", "parts/d435.yaml"]
)
def test_an_odd_number_is_refused_with_its_place_or_changes_a_robot_that_is_sound(folder, file):
    path, rng = folder / file, random.Random(file)
    good = path.read_text()
    content = "\n".join(line.partition("#")[0] for line in good.splitlines()) + "\n"
    places = [found.span() for found in NUMBER.finditer(content)]
    refused = 0
    for number in range(60):
        start, end = rng.choice(places)
        path.write_text(content[:start] + rng.choice(ODD) + content[end:])
        # A name of its own: equal paths are read once.
        robot = folder / f"robot{number}.yaml"
        shutil.copy(folder / "frankie.yaml", robot)
        try:
            limits = load_robot(robot).limits
        except ConfigError as error:
            refused += all(
                re.match(rf"{folder}/\S+\.yaml:\d+:\d+: .+; .+$", line)
                for line in str(error).splitlines()
            )
        else:
            refused += 1  # sound all the same
            for numbers in (limits.q_min, limits.q_max, limits.qd, limits.qdd, limits.base_twist):
                assert np.isfinite(numbers).all()
    assert refused == 60


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
