"""The wheel of the package `typodont`: Python files, and libtypodont.so with what it reads, as an installation has them.

$TYPODONT_PREFIX names an installation (cmake --install BUILD --component library --prefix PREFIX); without it the
library is built in this source tree.
"""

import os
import shutil
import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.dist import Distribution
from wheel.bdist_wheel import bdist_wheel


def installation(place: Path) -> Path:
    given = os.environ.get("TYPODONT_PREFIX")
    if given:
        return Path(given)
    tree = Path(__file__).resolve().parents[3]
    build = tree / "build" / "release"
    subprocess.run(["cmake", "--preset", "release", "-DTYPODONT_TESTS=OFF"], cwd=tree, check=True)
    subprocess.run(["cmake", "--build", build, "--target", "typodont_c", "typodont_openvdb"], check=True)
    subprocess.run(["cmake", "--install", build, "--component", "library", "--prefix", place], check=True)
    return place


class BuildWithLibrary(build_py):
    def run(self):
        shutil.rmtree(self.build_lib, ignore_errors=True)  # otherwise a file of an earlier build could replace its source
        super().run()
        native = Path(self.build_lib) / "typodont" / "native"
        prefix = installation(Path(self.build_lib).resolve() / "prefix")
        library = next(iter(sorted(prefix.glob("lib*/**/libtypodont.so.0"))), None)
        if library is None:
            raise SystemExit(f"{prefix}: no libtypodont.so.0 below it")
        for folder in ("lib", "include", "libexec/typodont", "share/typodont"):
            (native / folder).mkdir(parents=True)
        shutil.copy(library, native / "lib" / "libtypodont.so.0")
        for header in ("typodont.h", "typodont_sound.h", "typodont_calibration.h"):
            shutil.copy(prefix / "include" / header, native / "include")
        for part in ("typodont-openvdb", "typodont-calibration.so"):
            shutil.copy(prefix / "libexec/typodont" / part, native / "libexec/typodont")
        shutil.copytree(prefix / "share/typodont/assets", native / "share/typodont/assets")
        shutil.rmtree(Path(self.build_lib) / "prefix", ignore_errors=True)


class PlatformWheel(bdist_wheel):
    """For this machine's Linux; any Python 3, because the library is called through its C interface."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class WithLibrary(Distribution):
    def has_ext_modules(self):
        return True


setup(cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel}, distclass=WithLibrary)
