# SPDX-License-Identifier: MIT
"""A source package and a wheel, as pip makes them, in a fresh virtual environment."""

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


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return tmp_path_factory.mktemp("packages")


def environment():
    names = ("PYTHONPATH", "MYPYPATH")
    return {key: value for key, value in os.environ.items() if key not in names}


def pip(python, *arguments):
    offline = ["--no-index", "--no-build-isolation", "--disable-pip-version-check", "-q"]
    subprocess.run([python, "-m", "pip", *arguments, *offline], check=True, env=environment())


def test_source_package_builds_a_wheel_that_works(packages, root, tmp_path):
    sys.path.insert(0, str(root / "plugins/python"))
    import build_backend

    name = build_backend.build_sdist(str(packages))
    with tarfile.open(packages / name) as archive:
        archive.extractall(tmp_path)
    source = tmp_path / name[: -len(".tar.gz")]
    assert (source / "PKG-INFO").is_file() and not list(source.rglob("*.so"))
    # NumPy is the system's.
    venv.create(tmp_path / "venv", system_site_packages=True, with_pip=True)
    python = str(tmp_path / "venv/bin/python")
    pip(python, "wheel", str(source), "--no-deps", "-w", str(tmp_path / "wheels"))
    (wheel,) = (tmp_path / "wheels").glob("dynfilter-*.whl")
    pip(python, "install", str(wheel))
    checked = subprocess.run(
        [python, "-c", CHECK], check=True, env=environment(), cwd=tmp_path, capture_output=True, text=True
    )
    assert checked.stdout.startswith("works")
    library = next((tmp_path / "venv").rglob("_core*.so")).read_bytes()
    assert str(root).encode() not in library and str(tmp_path).encode() not in library
