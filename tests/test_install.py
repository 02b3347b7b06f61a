"""`install.sh`, and with it `make`: which Python it takes, asked of fakes on the path."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]

WORKS = f'#!/bin/sh\nexec {sys.executable} "$@"\n'
A_SHIM_WITHOUT_PYTHON = "#!/bin/sh\necho 'pyenv: command not found' >&2\nexit 127\n"


def of_version(major: int, minor: int) -> str:
    """A Python that says it is of this version."""
    told = f"import sys; sys.version_info = ({major}, {minor}, 0)\n"
    return f'#!/bin/sh\nshift\nexec {sys.executable} -c "{told}$1"\n'


@pytest.fixture
def choose(tmp_path):
    """What the installation says, and its exit code, with these programs before the shell's own."""

    def run(*folders: dict[str, str], **environment: str) -> tuple[str, int]:
        path = []
        for number, programs in enumerate(folders):
            folder = tmp_path / str(number)
            folder.mkdir()
            path.append(str(folder))
            for name, text in programs.items():
                (folder / name).write_text(text)
                (folder / name).chmod(0o755)
        tools = tmp_path / "tools"  # the shell's tools, and no Python
        tools.mkdir()
        for tool in ("sh", "dirname"):
            found = next(p for p in ("/bin", "/usr/bin") if (Path(p) / tool).exists())
            (tools / tool).symlink_to(Path(found) / tool)
        done = subprocess.run(
            ["/bin/sh", str(ROOT / "install.sh"), "--which"],
            env={"PATH": os.pathsep.join([*path, str(tools)]), **environment},
            capture_output=True,
            text=True,
            check=False,
        )
        said = (done.stdout + done.stderr).strip().replace(str(tmp_path), "")
        return said, done.returncode

    return run


EVERY = {"python3.13": WORKS, "python3.11": WORKS, "python3": WORKS}


@pytest.mark.parametrize(
    ("folders", "named", "taken"),
    [
        ([{"python3.13": WORKS}], {}, "/0/python3.13"),
        ([{"python3": of_version(3, 11)}], {}, "/0/python3"),
        ([{"python": of_version(3, 14)}], {}, "/0/python"),
        ([EVERY], {}, "/0/python3.11"),  # with which everything is tested
        ([{"python3.11": A_SHIM_WITHOUT_PYTHON}, {"python3.12": WORKS}], {}, "/1/python3.12"),
        ([{"mine": WORKS, "python3.11": WORKS}], {"PYTHON": "mine"}, "mine"),
    ],
)
def test_the_best_python_that_serves_is_taken(choose, folders, named, taken):
    assert choose(*folders, **named) == (taken, 0)


@pytest.mark.parametrize(
    ("folders", "named", "begins"),
    [
        ([], {}, "frankie-task needs Python 3.11 to 3.14 with venv"),
        ([{"python3": of_version(3, 10)}], {}, "frankie-task needs Python 3.11 to 3.14"),
        ([{"python3": of_version(3, 15)}], {}, "frankie-task needs Python 3.11 to 3.14"),
        (
            [{"mine": of_version(3, 9), "python3.11": WORKS}],
            {"PYTHON": "mine"},
            "PYTHON=mine: is no Python 3.11 to 3.14",
        ),
    ],
)
def test_without_any_there_is_one_line(choose, folders, named, begins):
    said, code = choose(*folders, **named)
    assert (code, said.count("\n")) == (2, 0)
    assert said.startswith(begins)


def test_the_package_asks_for_the_same_versions():
    assert PROJECT["requires-python"] == ">=3.11,<3.15"


PLATFORMS = {
    "macosx_arm64": ["macosx_14_0_arm64"],
    "manylinux_aarch64": [f"manylinux_2_{glibc}_aarch64" for glibc in (28, 27, 26, 24, 17)],
    "manylinux_x86_64": [f"manylinux_2_{glibc}_x86_64" for glibc in (28, 27, 26, 24, 17)],
}


@pytest.mark.slow
@pytest.mark.parametrize("version", ["3.11", "3.14"])
@pytest.mark.parametrize("platform", PLATFORMS)
def test_every_package_of_a_run_has_a_wheel(platform, version, tmp_path):
    extras = ("assets", "page", "physics")  # which install.sh brings
    wanted = [*PROJECT["dependencies"], *(f for e in extras for f in EXTRAS[e])]
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed"]
    where = ["--target", str(tmp_path), "--only-binary=:all:", "--python-version", version]
    tags = [f"--platform={tag}" for tag in PLATFORMS[platform]]
    asked = [*command, *where, *tags, "--constraint", str(ROOT / "constraints.txt"), *wanted]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    if done.returncode and "after connection broken by" in done.stderr:
        pytest.skip("the index of packages cannot be reached")
    assert done.returncode == 0, done.stderr


def test_make_installs_with_it():
    done = subprocess.run(
        ["make", "--dry-run", "--always-make", "run", "PYTHON=python3.13"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert 'PYTHON="python3.13" ./install.sh' in done.stdout
    assert "frankie-task run trees/pick_place.yaml" in done.stdout
