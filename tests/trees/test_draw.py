"""Pictures of trees: everything that a task says is in them, and nothing overlaps."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest
from everything import write_everything

from trees.draw import FORMATS, Box, boxes
from trees.language import load

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def everything(tmp_path) -> Box:
    return boxes(load(write_everything(tmp_path), open_parameters=True).root)


def below(box: Box) -> list[Box]:
    return [box, *(other for child in box.children for other in below(child))]


def test_the_text_has_a_line_a_node_with_name_arguments_and_modifiers(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(
        "task: t\n"
        "params: {tries: {default: 3}}\n"
        "poses: {home: {base: [0, 0], heading_deg: 0}}\n"
        "tree:\n"
        "  sequence:\n"
        "    - name: pick\n"
        "      retry: $tries\n"
        "      fallback: [holding_object, open_gripper]\n"
        "    - while: arm_healthy\n"
        "      once: true\n"
        "      navigate: {to: home, speed_m_s: 0.5}\n"
    )
    assert FORMATS["text"](boxes(load(path, open_parameters=True).root)) == (
        "→ sequence\n"
        "├─ ? pick (fallback)  [retry: $tries]\n"
        "│  ├─ ○ holding_object\n"
        "│  └─ • open_gripper\n"
        "└─ • navigate  to: home  speed_m_s: 0.5  [once]  [while: arm_healthy]\n"
    )


def rectangles(picture: ElementTree.Element) -> list[tuple[float, float, float, float]]:
    """Left, top, right, bottom of each box, the background left out."""
    found = []
    for rect in picture.iter(f"{SVG}rect"):
        if rect.get("x"):
            x, y, width, height = (float(rect.get(key)) for key in ("x", "y", "width", "height"))
            found.append((x, y, x + width, y + height))
    return found


def test_no_two_boxes_of_the_picture_touch_and_all_lie_in_it(everything):
    picture = ElementTree.fromstring(FORMATS["svg"](everything))
    placed = rectangles(picture)
    assert len(placed) == len(below(everything))
    for number, (left, top, right, bottom) in enumerate(placed):
        assert 0 <= left < right <= float(picture.get("width"))
        assert 0 <= top < bottom <= float(picture.get("height"))
        for other in placed[number + 1 :]:
            apart = right < other[0] or other[2] < left or bottom < other[1] or other[3] < top
            assert apart, (number, other)


def test_the_picture_says_everything_in_letters_that_fit_their_box(everything):
    picture = ElementTree.fromstring(FORMATS["svg"](everything))
    said = [element.text for element in picture.iter(f"{SVG}text")]
    for box in below(everything):
        for line in (f"{box.symbol} {box.title}", *box.arguments, *box.modifiers):
            assert line in said
    placed = rectangles(picture)
    for element in picture.iter(f"{SVG}text"):
        x, y = float(element.get("x")), float(element.get("y"))
        end = x + 7.23 * len(element.text)  # a monospaced letter of 12 px
        assert any(a <= x and end <= c and b <= y <= d for a, b, c, d in placed), element.text


def test_texts_from_a_task_cannot_break_a_picture(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(
        'task: t\ntree: {name: "a\\"]-->b;<b>&`#", sequence: [{say: {text: "</text><x> %% ;"}}]}\n'
    )
    root = boxes(load(path).root)
    said = [
        element.text for element in ElementTree.fromstring(FORMATS["svg"](root)).iter(f"{SVG}text")
    ]
    assert "text: </text><x> %% ;" in said
