"""Tables of figures."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias, TypeVar

from rich.table import Table

Row = TypeVar("Row")
Columns: TypeAlias = Mapping[str, Callable[[Row], object]]


def table(
    title: str, rows: Iterable[Row], words: Columns[Row], figures: Columns[Row], **look: Any
) -> Table:
    """A table with columns by their heads: words to the left, then figures to the right."""
    made = Table(title=title, **look)
    for head in words:
        made.add_column(head, no_wrap=True)
    for head in figures:
        made.add_column(head, justify="right")
    for row in rows:
        made.add_row(*(str(cell(row)) for cell in (*words.values(), *figures.values())))
    return made


def fixed(value: float | None, digits: int) -> str:
    """A number with so many digits after the point; `-` for None."""
    return "-" if value is None else f"{value:.{digits}f}"
