"""What several looks agree on, told from rendered frames."""

from dataclasses import replace

import pytest
from test_objects import BLUE, RED, REGION, frame, put

from perception import DetectedObjects, consensus, segment_objects
from robots import Box

LONG = put(Box((0.05, 0.02, 0.02)), 0.05, -0.03, 0.04, RED)
LEFT, RIGHT = (put(Box((0.021, 0.02, 0.02)), x, -0.03, 0.04, RED) for x in (0.021, 0.079))
OTHER = put(Box((0.02, 0.02, 0.02)), -0.08, 0.05, 0.04, BLUE)


def look(*things):
    return segment_objects(frame(*things), REGION)


def test_a_frame_that_cuts_a_thing_in_two_is_outvoted():
    whole, halves = look(LONG, OTHER), look(LEFT, RIGHT, OTHER)
    assert len(halves) == 3
    for looks in ((whole, halves, whole), (halves, whole, whole), (whole, whole, halves)):
        blue, red = consensus(looks)
        assert (blue.colour, red.colour) == ("blue", "red")
        assert red.size == pytest.approx((0.1, 0.04, 0.04), abs=0.004)


def test_what_one_frame_alone_shows_is_nothing_and_what_one_lacks_is_something():
    assert len(consensus((look(OTHER), look(LONG, OTHER), look(OTHER)))) == 1
    assert len(consensus((look(LONG, OTHER), look(OTHER), look(LONG, OTHER)))) == 2
    assert consensus((look(), look(), look(OTHER))) == ()


def test_a_size_is_the_median_and_a_colour_that_of_most():
    (one,) = look(OTHER)
    looks = [
        DetectedObjects([replace(one, size=(0.04, width, 0.04), area=area, colour=colour)])
        for width, area, colour in (
            (0.020, 0.0010, "blue"),
            (0.030, 0.0020, "purple"),
            (0.090, 0.0016, "blue"),
        )
    ]
    (typical,) = consensus(looks)
    assert (typical.width, typical.area, typical.colour) == (0.030, 0.0016, "blue")
