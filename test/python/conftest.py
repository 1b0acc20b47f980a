# SPDX-License-Identifier: MIT
import os
from pathlib import Path

import pytest

import dynfilter

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def root():
    return ROOT


@pytest.fixture(scope="session")
def rendered():
    """A short rendered sequence with movers."""
    return dynfilter.render("walking_xyz", frames=12)


@pytest.fixture
def tool():
    """Path of a program of the build; the variable is set by CMake."""

    def find(variable):
        path = os.environ.get(variable)
        assert path, f"{variable} is not set: run these tests with ctest"
        return path

    return find


def play(pipeline, scene, frames=8):
    """The verdict on the last frame."""
    for k in range(frames):
        verdict = pipeline.before_pose(**scene.frame(k).arguments())
    return verdict


@pytest.fixture(name="play")
def _play():
    return play
