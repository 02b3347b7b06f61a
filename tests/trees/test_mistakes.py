"""What cannot be meant is refused where it stands, and what hardly is, is warned of.

Mistakes of form and names are in the folder `broken`.
"""

from mistakes import file_with, found_in, marked, table

from config import Severity


@table("errors")
def test_what_cannot_be_meant_is_refused_where_it_stands(tmp_path, row):
    text = file_with(row["task"])
    [found] = found_in(tmp_path, text)
    assert (found.location.line, found.location.column) == marked(text)
    assert row["tells"] in str(found)
    assert found.hint


@table("warnings")
def test_what_is_probably_not_meant_is_warned_of(tmp_path, row):
    text = file_with(row["task"])
    assert found_in(tmp_path, text) == []
    [found] = found_in(tmp_path, text, Severity.WARNING)
    assert (found.location.line, found.location.column) == marked(text)
    assert row["tells"] in str(found)


@table("fine")
def test_what_can_be_meant_is_good(tmp_path, row):
    text = file_with(row)
    assert found_in(tmp_path, text) == []
    assert found_in(tmp_path, text, Severity.WARNING) == []


def test_values_within_values_are_bounded(tmp_path):
    numbers = ", ".join(str(number) for number in range(100))
    inner = f"for_each: {{item: b, in: [{numbers}], do: {{wait: {{duration_s: $b}}}}}}"
    text = file_with(f"- ¦for_each: {{item: a, in: [{numbers}], do: {{{inner}}}}}")
    found = found_in(tmp_path, text)
    assert "more than 1000 nodes" in str(found[0])
