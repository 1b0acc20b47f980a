# SPDX-License-Identifier: MIT
"""A source package and a wheel, as pip makes them, in a fresh virtual environment."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
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
try:
    dynfilter.sequences.Recording("clip.mp4")
except Exception as error:
    assert "is no video that OpenCV can read" in str(error), error  # so the module that reads videos is there
else:
    raise AssertionError("clip.mp4")
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
    (tmp_path / "clip.mp4").write_bytes(b"no video")
    checked = subprocess.run(
        [python, "-c", CHECK], check=True, env=environment(), cwd=tmp_path, capture_output=True, text=True
    )
    assert checked.stdout.startswith("works")
    library = next((tmp_path / "venv").rglob("_core*.so")).read_bytes()
    assert str(root).encode() not in library, "the module names the source tree"
    subprocess.run([python, "-m", "pip", "uninstall", "-y", "-q", "dynfilter"], check=True, env=environment())
    assert not list((tmp_path / "venv").rglob("_core*.so"))


def offline_install(python, *what, **variables):
    command = [python, "-m", "pip", "install", *what, "--no-index", "--no-build-isolation", "--disable-pip-version-check"]
    return subprocess.run(command, env=environment(**variables), capture_output=True, text=True)


def test_editable_install_follows_the_sources(root, tmp_path, tool):
    """A copy of the sources, one of which is then changed, with the libraries of this build."""
    source = tmp_path / "source"
    for part in ("plugins/python", "examples/pipelines", "include/dynfilter/version.hpp", "README.md", "LICENSE", "pyproject.toml"):
        (source / part).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (root / part).is_dir() else shutil.copy
        copy(root / part, source / part)
    venv.create(tmp_path / "venv", system_site_packages=True, with_pip=True)
    python = str(tmp_path / "venv/bin/python")
    done = offline_install(python, "-e", str(source), DYNFILTER_PYTHON_BUILD_DIR=tool("BUILD_FOLDER"))
    assert done.returncode == 0, done.stdout + done.stderr
    with open(source / "plugins/python/dynfilter/paths.py", "a") as file:
        file.write("changed = 5\n")
    show = "import dynfilter, dynfilter.paths as p; print(p.changed, len(dynfilter.presets()) > 10, dynfilter.Pipeline('none'))"
    ran = subprocess.run([python, "-c", show], env=environment(), cwd=tmp_path, capture_output=True, text=True)
    assert ran.stdout.startswith("5 True"), ran.stdout + ran.stderr
    subprocess.run([python, "-m", "pip", "uninstall", "-y", "-q", "dynfilter"], check=True, env=environment())
    gone = subprocess.run([python, "-c", "import dynfilter"], env=environment(), cwd=tmp_path, capture_output=True, text=True)
    assert "No module named" in gone.stderr


@pytest.fixture(scope="module")
def without_numpy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bare")
    venv.create(folder / "venv", system_site_packages=False, with_pip=True)
    return str(folder / "venv/bin/python")


@pytest.mark.parametrize("editable", [(), ("-e",)])
def test_pip_misses_numpy_before_anything_is_compiled(root, tmp_path, without_numpy, editable):
    build = tmp_path / "build"
    begin = time.monotonic()
    done = offline_install(without_numpy, *editable, str(root), DYNFILTER_PYTHON_BUILD_DIR=str(build))
    assert done.returncode != 0 and "numpy" in done.stderr, done.stdout + done.stderr
    assert not build.exists(), "configured before the metadata was read"
    assert time.monotonic() - begin < 60


def test_metadata_names_the_versions_of_pyproject(backend, root, tmp_path):
    info = backend.prepare_metadata_for_build_wheel(str(tmp_path))
    text = (tmp_path / info / "METADATA").read_text()
    bounds = [line for line in (root / "pyproject.toml").read_text().splitlines() if line.startswith("dependencies")]
    (needed,) = [line for line in text.splitlines() if line.startswith("Requires-Dist: ")]
    assert needed == "Requires-Dist: numpy>=1.24,<2" and needed.split(": ")[1] in bounds[0]


def test_pip_downloads_no_plots_unless_it_is_told_to(backend, monkeypatch):
    calls = []
    monkeypatch.setattr(backend, "run", lambda *command: calls.append(command))
    backend.configure("build", {})
    backend.configure("build", {"DYNFILTER_REPORT_PLOTS": "ON"})
    assert ["-DDYNFILTER_REPORT_PLOTS=OFF" in calls[0], "-DDYNFILTER_REPORT_PLOTS=ON" in calls[1]] == [True, True]


def test_missing_tools_are_one_line(backend, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CXX", raising=False)
    for hook in ("prepare_metadata_for_build_wheel", "prepare_metadata_for_build_editable", "build_wheel", "build_editable"):
        with pytest.raises(SystemExit, match=r"^dynfilter: not found: cmake, a C\+\+ compiler \(g\+\+\). See docs/how-to/python.md$"):
            getattr(backend, hook)(str(tmp_path))


def imported(python, *folders):
    path = os.pathsep.join(map(str, folders))
    done = subprocess.run([python, "-c", "import dynfilter"], env=environment(PYTHONPATH=path), capture_output=True, text=True)
    return done.stderr.strip().splitlines()[-1:]


def test_import_without_numpy_names_it(tool, tmp_path, without_numpy):
    package = tool("BUILD_FOLDER") + "/plugins/python"
    (line,) = imported(without_numpy, package)
    assert line.startswith("ImportError: dynfilter needs NumPy: run `pip install"), line
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy/__init__.py").write_text("__version__ = '2.1.0'\n")
    (line,) = imported(without_numpy, package, tmp_path)
    assert "found 2.1.0" in line or "numpy." in line, line  # the second with a pybind11 that knows NumPy 2


def test_wheel_is_of_this_python_and_machine(backend):
    cpython = f"cp{sys.version_info.major}{sys.version_info.minor}"
    about = backend.info_files()["WHEEL"].decode()
    (tag,) = re.findall(r"^Tag: (.*)$", about, re.M)
    assert re.fullmatch(rf"{cpython}-{cpython}-linux_\w+", tag)
    assert "Root-Is-Purelib: false" in about
    assert backend.wheel_name() == f"dynfilter-{backend.version()}-{tag}.whl"


def test_source_package_has_what_the_build_needs(root, backend, tmp_path):
    name = backend.build_sdist(str(tmp_path))
    with tarfile.open(tmp_path / name) as archive:
        archive.extractall(tmp_path)
    source = tmp_path / name[: -len(".tar.gz")]
    assert (source / "PKG-INFO").read_text().startswith("Metadata-Version: 2.1\nName: dynfilter\n")
    assert not list(source.rglob("*.so"))
    assert missing_includes(root, source) == []
    backend.ROOT = source
    backend.configure(str(tmp_path / "build"), {"Python3_EXECUTABLE": sys.executable})


def missing_includes(root, source):
    """What the module's sources include, also through others, that is in the repository and not in the package."""
    folders = ["include", "plugins/detectors/include", "plugins/recorder/include", "plugins/inertial/include", "examples/dynfilter"]
    compiled = ["plugins/python/src", "plugins/detectors/src", "plugins/recorder/src", *(f"examples/dynfilter/{room}" for room in ("eval", "io", "odometry", "render"))]
    todo = [path.relative_to(root) for folder in compiled for path in (root / folder).glob("*.cpp")]
    seen, missing = set(todo), set()
    while todo:
        path = todo.pop()
        if not (source / path).is_file():
            missing.add(str(path))
        for included in re.findall(r'^#include ["<](.*)[">]', (root / path).read_text(), re.M):
            for folder in [path.parent, *folders]:
                found = type(path)(folder) / included
                if (root / found).is_file() and found not in seen:
                    seen.add(found)
                    todo.append(found)
    assert len(seen) > 200
    return sorted(missing)
