"""Two task files, one with the other as a subtree, and the errors of changed ones."""

import shutil
from pathlib import Path

from tree_toys import TOYS

from trees.language import check

FILES = Path(__file__).parent / "two_files"
TOP, PART = ((FILES / name).read_text("utf-8") for name in ("top.yaml", "parts/part.yaml"))


def write_files(folder: Path) -> Path:
    return Path(shutil.copytree(FILES, folder, dirs_exist_ok=True))


def errors(folder, top: str = TOP, part: str = PART) -> list[str]:
    (folder / "top.yaml").write_text(top)
    (folder / "parts" / "part.yaml").write_text(part)
    found = check(folder / "top.yaml", leaves=TOYS)
    return [str(diagnostic).removeprefix(f"{folder}/") for diagnostic in found]
