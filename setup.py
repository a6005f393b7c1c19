"""`pip install .`: the compiled part of the Python module by CMake; pyproject.toml says the rest."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

TREE = pathlib.Path(__file__).parent
# What is made lies beside CMake's folders, not among the sources.
MADE = TREE / "build/pip"


class BuildByCMake(build_ext):
    """In a folder of its own, or in the one that RECEDE_BUILD names, which was configured for this Python."""

    def build_extension(self, extension):
        folder = os.environ.get("RECEDE_BUILD")
        if not folder:
            folder = self.build_temp
            generator = ["-G", "Ninja"] if shutil.which("ninja") else []
            subprocess.run(["cmake", "-S", TREE, "-B", folder, *generator, "-DCMAKE_BUILD_TYPE=Release",
                            "-DRECEDE_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"], check=True)
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        subprocess.run(["cmake", "--build", folder, "--target", "recede_python", "--parallel", jobs], check=True)
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(pathlib.Path(folder, "python/recede", target.name), target)


MADE.mkdir(parents=True, exist_ok=True)
setup(
    version=re.search(r"^project\(recede VERSION ([\d.]+)", (TREE / "CMakeLists.txt").read_text(), re.M)[1],
    ext_modules=[Extension("recede._recede", sources=[])],
    cmdclass={"build_ext": BuildByCMake},
    options={"build": {"build_base": str(MADE)}, "egg_info": {"egg_base": str(MADE)}},
)
