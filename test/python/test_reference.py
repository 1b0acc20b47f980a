# SPDX-License-Identifier: MIT
"""The reference for Python says what the package has. DYNFILTER_UPDATE_DOCS=1 writes the page."""

import os

import dynfilter
import pytest
import reference_page

MOST_BYTES = 8_000


def test_every_name_is_in_one_section():
    named = [name for names in reference_page.SECTIONS.values() for name in names.split()]
    assert sorted(named) == sorted(set(named)), "twice"
    assert set(dynfilter.__all__) <= set(named)


@pytest.mark.skipif(not dynfilter.has_odometry, reason="built without the odometry")
def test_the_page_is_that_of_the_package(root):
    page = root / "docs/reference/python.md"
    text = reference_page.page()
    assert len(text.encode()) <= MOST_BYTES
    if os.environ.get("DYNFILTER_UPDATE_DOCS"):
        page.write_text(text)
    assert page.read_text() == text, "run this test with DYNFILTER_UPDATE_DOCS=1"


def test_arguments_are_those_of_the_stub():
    known = reference_page.stubs()
    assert known["presets"] == ""
    assert known["Evidence.match"] == "gap_frames=, *, keyframe="
    assert known["Pipeline.before_pose"].startswith("keypoints, *, timestamp, ")


def test_summaries_are_first_sentences():
    class Said:
        def f(self):
            """f(x: int) -> int

            Adds one, e.g. to x. It is fast."""

    assert reference_page.summary(Said.f) == "Adds one, e.g. to x"
