# SPDX-License-Identifier: MIT
"""Builds the Python package with CMake: the backend that pyproject.toml names (PEP 517 and 660).

A setting of CMake is given as `pip install . --config-settings=NAME=VALUE`, or in the variable CMAKE_ARGS.
"""

import base64
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ["CMakeLists.txt", "LICENSE", "README.md", "pyproject.toml", "cmake", "include", "plugins"]
EXAMPLES = ["examples/pipelines"] + [
    "examples/dynfilter/" + room for room in ("eval", "io", "map", "media", "odometry", "render", "report", "running", "text")
]


def version():
    text = (ROOT / "include/dynfilter/version.hpp").read_text()
    return re.search(r'DYNFILTER_VERSION "([0-9.]+)"', text).group(1)


def dependencies():
    """As pyproject.toml has them, without a parser of TOML: Python has none before 3.11."""
    text = (ROOT / "pyproject.toml").read_text()
    return re.findall(r'"([^"]+)"', re.search(r"^dependencies = \[(.*)\]$", text, re.MULTILINE).group(1))


def metadata():
    return (
        f"Metadata-Version: 2.1\nName: dynfilter\nVersion: {version()}\n"
        "Summary: Rejectors of features on moving objects for visual SLAM\nLicense: MIT\nRequires-Python: >=3.9\n"
        + "".join(f"Requires-Dist: {needed}\n" for needed in dependencies())
        + "Description-Content-Type: text/markdown\n\n"
        + (ROOT / "README.md").read_text()
    )


def tag():
    """The module works with this Python on this kind of machine."""
    cpython = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{cpython}-{cpython}-{platform}"


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Before anything is compiled, so that pip finds out first whether it can get NumPy."""
    check_tools()
    info = Path(metadata_directory) / info_folder()
    info.mkdir()
    for name, data in info_files().items():
        (info / name).write_bytes(data)
    return info.name


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def check_tools():
    """One line instead of the output of CMake."""
    wanted = {
        "cmake": shutil.which("cmake"),
        "a C++ compiler (g++)": os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++"),
        "Python.h (python3-dev)": os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")),
    }
    missing = [name for name, found in wanted.items() if not found]
    if missing:
        sys.exit(f"dynfilter: not found: {', '.join(missing)}. See docs/how-to/python.md")


def wheel_name():
    return f"dynfilter-{version()}-{tag()}.whl"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    check_tools()
    name = wheel_name()
    with tempfile.TemporaryDirectory() as stage:
        build_dir = os.environ.get("DYNFILTER_PYTHON_BUILD_DIR") or os.path.join(stage, "build")
        if not os.path.exists(os.path.join(build_dir, "CMakeCache.txt")):
            configure(build_dir, config_settings or {})
        installed = Path(stage) / "install"
        run("cmake", "--build", build_dir, "--target", "dynfilter_python", "--parallel", str(jobs()))
        run("cmake", "--install", build_dir, "--component", "python", "--strip", "--prefix", str(installed))
        (module,) = installed.rglob("_core*.so")
        write_wheel(Path(wheel_directory) / name, files_of(module.parent.parent))
    return name


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """The package is a folder of links: to the Python sources, the pipelines and the module in the build tree.

    A file that is new in the sources appears with the next `pip install -e .`.
    """
    check_tools()
    build_dir = Path(os.environ.get("DYNFILTER_PYTHON_BUILD_DIR") or ROOT / "build" / f"editable-{tag()}")
    if not (build_dir / "CMakeCache.txt").exists():
        configure(str(build_dir), config_settings or {})
    run("cmake", "--build", str(build_dir), "--target", "dynfilter_python", "--parallel", str(jobs()))
    folder = build_dir / "editable"
    shutil.rmtree(folder, ignore_errors=True)
    package = folder / "dynfilter"
    package.mkdir(parents=True)
    (module,) = (build_dir / "plugins/python/dynfilter").glob("_core*.so")
    sources = [path for path in (ROOT / "plugins/python/dynfilter").iterdir() if path.is_file()]
    for path in [*sources, module]:
        (package / path.name).symlink_to(path)
    (package / "pipelines").symlink_to(ROOT / "examples/pipelines")
    write_wheel(Path(wheel_directory) / wheel_name(), {"dynfilter_editable.pth": f"{folder}\n".encode()})
    return wheel_name()


def configure(build_dir, settings):
    """Nothing but the package. A tree in DYNFILTER_PYTHON_BUILD_DIR that is configured already is taken as it is."""
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "DYNFILTER_BUILD_PYTHON": "ON",
        "DYNFILTER_BUILD_EXAMPLES": "OFF",
        "DYNFILTER_BUILD_PLUGINS": "OFF",
        "DYNFILTER_BUILD_FACADE": "OFF",
        "DYNFILTER_BUILD_TESTS": "OFF",
        "DYNFILTER_WARNINGS_AS_ERRORS": "OFF",  # a compiler that is newer than ours warns of more
        "DYNFILTER_REPORT_PLOTS": "OFF",  # uPlot comes by npm; without it reports have plain plots
        "Python3_EXECUTABLE": sys.executable,
        **settings,
    }
    definitions = [f"-D{key}={value}" for key, value in options.items()]
    run("cmake", "-S", str(ROOT), "-B", build_dir, *definitions, *shlex.split(os.environ.get("CMAKE_ARGS", "")))


def jobs():
    return os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL") or os.cpu_count() or 1


def run(*command):
    subprocess.run(command, check=True)


def info_folder():
    return f"dynfilter-{version()}.dist-info"


def info_files():
    about = f"Wheel-Version: 1.0\nGenerator: dynfilter\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {
        "METADATA": metadata().encode(),
        "LICENSE": (ROOT / "LICENSE").read_bytes(),
        "WHEEL": about.encode(),
    }


def files_of(tree):
    return {str(f.relative_to(tree)): f.read_bytes() for f in sorted(tree.rglob("*")) if f.is_file()}


def write_wheel(path, files):
    info = info_folder()
    files = {**files, **{f"{info}/{name}": data for name, data in info_files().items()}}
    record = "".join(f"{name},{digest(data)},{len(data)}\n" for name, data in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in files.items():
            wheel.writestr(name, data)


def digest(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def build_sdist(sdist_directory, config_settings=None):
    name = f"dynfilter-{version()}"
    with tempfile.TemporaryDirectory() as stage:
        info = Path(stage) / "PKG-INFO"
        info.write_text(metadata())
        with tarfile.open(Path(sdist_directory) / f"{name}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as archive:
            for source in SOURCES + EXAMPLES:
                archive.add(ROOT / source, f"{name}/{source}", filter=source_only)
            archive.add(info, f"{name}/PKG-INFO")
    return f"{name}.tar.gz"


def source_only(entry):
    generated = re.search(r"(__pycache__|\.pyc$|\.so$|/build(/|$))", entry.name)
    return None if generated else entry
