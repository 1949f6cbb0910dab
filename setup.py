"""What pyproject.toml cannot say: CMake builds the compiled module, and knows the version.

The build needs a compiler, CMake, Eigen 3.4, the headers of Boost 1.74 and libfmt (libeigen3-dev, libboost-dev, libfmt-dev).
CMAKE_ARGS has further options for CMake.
"""
import os
import pathlib
import re
import shlex
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

source = pathlib.Path(__file__).resolve().parent
version = re.search(r"project\(vcell VERSION ([\d.]+)", (source / "CMakeLists.txt").read_text())[1]


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        folder = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent  # the package's
        build = pathlib.Path(self.build_temp).resolve()
        others = ["PROGRAM", "TESTS", "BENCHES", "EXAMPLES"]
        subprocess.run(["cmake", "-S", source, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DVCELL_PYTHON=ON",
                        f"-DPython3_EXECUTABLE={sys.executable}", f"-DVCELL_PYTHON_DIR={folder.name}",
                        *(f"-DVCELL_BUILD_{other}=OFF" for other in others), *shlex.split(os.environ.get("CMAKE_ARGS", ""))],
                       check=True)
        subprocess.run(["cmake", "--build", build, "--target", "vcell_python", "--parallel", str(os.cpu_count())], check=True)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", folder.parent], check=True)


setup(version=version, ext_modules=[Extension("vcell._vcell", [])], cmdclass={"build_ext": CMakeBuild})
