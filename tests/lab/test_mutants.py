"""Changes of one operator or constant, and whether a test sees them."""

from pathlib import Path

from lab.mutants import mutants_of

SOURCE = '''"""A ä."""

def near(x: float, is_far: bool = False) -> bool:
    """Whether 1 < 2."""
    return not (is_far) and abs(x - 1) <= 0.5 and x // y**z and f"{1 + 1}"
'''


def test_every_operator_and_constant_that_decides_is_changed_once():
    found = [SOURCE[one.start : one.end] + one.text for one in mutants_of(Path("a.py"), SOURCE)]
    assert found == ["FalseTrue", "andor", "not ", "<=>", "-+", "12", "0.51.0", "//*", "***"]
    for one in mutants_of(Path("a.py"), SOURCE):
        changed = one.of(SOURCE)
        assert changed != SOURCE
        compile(changed, "a.py", "exec")
