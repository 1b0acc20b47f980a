# SPDX-License-Identifier: MIT
"""Builds the Python package with CMake: the backend that pyproject.toml names (PEP 517).

A setting of CMake is given as `pip install . --config-settings=NAME=VALUE`, or in the variable CMAKE_ARGS.
"""

import base64
import hashlib
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ["CMakeLists.txt", "LICENSE", "README.md", "pyproject.toml", "cmake", "include", "plugins"]
EXAMPLES = ["examples/pipelines", "examples/dynfilter/odometry", "examples/dynfilter/running", "examples/dynfilter/text"]


def version():
    text = (ROOT / "include/dynfilter/version.hpp").read_text()
    return re.search(r'DYNFILTER_VERSION "([0-9.]+)"', text).group(1)


def metadata():
    return (
        f"Metadata-Version: 2.1\nName: dynfilter\nVersion: {version()}\n"
        "Summary: Rejectors of features on moving objects for visual SLAM\nLicense: MIT\n"
        "Requires-Python: >=3.9\nRequires-Dist: numpy\nDescription-Content-Type: text/markdown\n\n"
        + (ROOT / "README.md").read_text()
    )


def tag():
    """The module works with this Python on this kind of machine."""
    cpython = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{cpython}-{cpython}-{platform}"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"dynfilter-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as stage:
        build_dir = os.environ.get("DYNFILTER_PYTHON_BUILD_DIR") or os.path.join(stage, "build")
        if not os.path.exists(os.path.join(build_dir, "CMakeCache.txt")):
            configure(build_dir, config_settings or {})
        installed = Path(stage) / "install"
        run("cmake", "--build", build_dir, "--target", "dynfilter_python", "--parallel", str(jobs()))
        run("cmake", "--install", build_dir, "--component", "python", "--strip", "--prefix", str(installed))
        (module,) = installed.rglob("_core*.so")
        write_wheel(Path(wheel_directory) / name, module.parent.parent)
    return name


def configure(build_dir, settings):
    """Nothing but the package. A tree in DYNFILTER_PYTHON_BUILD_DIR that is configured already is taken as it is."""
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "DYNFILTER_BUILD_PYTHON": "ON",
        "DYNFILTER_BUILD_EXAMPLES": "OFF",
        "DYNFILTER_BUILD_PLUGINS": "OFF",
        "DYNFILTER_BUILD_FACADE": "OFF",
        "DYNFILTER_BUILD_TESTS": "OFF",
        "Python3_EXECUTABLE": sys.executable,
        **settings,
    }
    definitions = [f"-D{key}={value}" for key, value in options.items()]
    run("cmake", "-S", str(ROOT), "-B", build_dir, *definitions, *shlex.split(os.environ.get("CMAKE_ARGS", "")))


def jobs():
    return os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL") or os.cpu_count() or 1


def run(*command):
    subprocess.run(command, check=True)


def write_wheel(path, tree):
    info = f"dynfilter-{version()}.dist-info"
    files = {str(f.relative_to(tree)): f.read_bytes() for f in sorted(tree.rglob("*")) if f.is_file()}
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: dynfilter\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode()
    )
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
