"""A folder of broken files: each says in its first lines which diagnostics it has, and where."""

import re
from pathlib import Path

import pytest

from trees.language import check

FOLDER = Path(__file__).parent / "broken"
FILES = sorted(FOLDER.glob("*.yaml"))
EXPECTED = re.compile(r"# expect (?:(?P<file>\S+\.yaml):)?(?P<place>\d+:\d+): (?P<message>.+)")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_mistake_is_found_where_it_is(path):
    expected = [match for match in map(EXPECTED.fullmatch, path.read_text().splitlines()) if match]
    found = [
        diagnostic
        for diagnostic in map(str, check(path))
        if "warning" not in diagnostic.split(" ")[1]
    ]
    assert len(found) == len(expected), found
    for text, match in zip(found, expected, strict=True):
        assert text.startswith(f"{FOLDER / (match['file'] or path.name)}:{match['place']}: ")
        assert match["message"] in text
