# SPDX-License-Identifier: MIT
"""A source package and a wheel, as pip makes them, in a fresh virtual environment."""

import importlib
import os
import subprocess
import sys
import tarfile
import venv

import pytest

CHECK = """
import dynfilter, numpy, sys
assert dynfilter.__file__.startswith(sys.prefix), dynfilter.__file__
pipeline = dynfilter.Pipeline("dynfilter")
scene = dynfilter.ExactScene("general")
for k in range(8):
    verdict = pipeline.before_pose(**scene.frame(k).arguments())
frame = scene.frame(7)
assert not verdict.keep[frame.dynamic].any()
assert len(dynfilter.presets()) > 10
print("works", dynfilter.__version__)
"""


def environment(**more):
    names = ("PYTHONPATH", "MYPYPATH")
    return {**{key: value for key, value in os.environ.items() if key not in names}, **more}


@pytest.fixture
def backend(root, monkeypatch):
    monkeypatch.syspath_prepend(str(root / "plugins/python"))
    return importlib.import_module("build_backend")


def test_wheel_in_a_fresh_virtual_environment(root, tmp_path, tool):
    """As `pip install .`, with the libraries of this build."""
    venv.create(tmp_path / "venv", system_site_packages=True, with_pip=True)  # NumPy is the system's
    python = str(tmp_path / "venv/bin/python")
    offline = ["--no-index", "--no-build-isolation", "--disable-pip-version-check", "-q"]
    subprocess.run(
        [python, "-m", "pip", "install", str(root), *offline],
        check=True,
        env=environment(DYNFILTER_PYTHON_BUILD_DIR=tool("BUILD_FOLDER"), CMAKE_BUILD_PARALLEL_LEVEL="1"),
    )
    checked = subprocess.run(
        [python, "-c", CHECK], check=True, env=environment(), cwd=tmp_path, capture_output=True, text=True
    )
    assert checked.stdout.startswith("works")
    library = next((tmp_path / "venv").rglob("_core*.so")).read_bytes()
    assert str(root).encode() not in library, "the module names the source tree"
    subprocess.run([python, "-m", "pip", "uninstall", "-y", "-q", "dynfilter"], check=True, env=environment())
    assert not list((tmp_path / "venv").rglob("_core*.so"))


def test_source_package_has_what_the_build_needs(backend, tmp_path):
    name = backend.build_sdist(str(tmp_path))
    with tarfile.open(tmp_path / name) as archive:
        archive.extractall(tmp_path)
    source = tmp_path / name[: -len(".tar.gz")]
    assert (source / "PKG-INFO").read_text().startswith("Metadata-Version: 2.1\nName: dynfilter\n")
    assert not list(source.rglob("*.so"))
    backend.ROOT = source
    backend.configure(str(tmp_path / "build"), {"Python3_EXECUTABLE": sys.executable})
