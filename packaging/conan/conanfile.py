"""Recipe for Conan 2: `conan create packaging/conan` makes the package of the checkout, or of the unpacked release, that it lies in."""

import os
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir
from conan.tools.system.package_manager import Apt

required_conan_version = ">=2.4"


class ConsimdRecipe(ConanFile):
    name = "consimd"
    description = "Vectorised consensus kernels and solvers for 3D registration from correspondences"
    license = "MIT"
    topics = ("simd", "registration", "ransac", "point-cloud")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "kernels_only": [True, False], "studies": [True, False]}
    default_options = {"shared": False, "kernels_only": False, "studies": False}

    @property
    def _checkout(self):
        return os.path.join(self.recipe_folder, "..", "..")

    def set_version(self):
        lists = load(self, os.path.join(self._checkout, "CMakeLists.txt"))
        self.version = re.search(r"project\(consimd VERSION ([\d.]+)", lists).group(1)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "text/*", "kernels/*", "poses/*", "solvers/*", "features/*", "synth/*", "studies/*"):
            copy(self, pattern, self._checkout, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("xsimd/[>=8.1 <15]")
        if not self.options.kernels_only:
            self.requires("eigen/[>=3.4 <6]", transitive_headers=True)
            self.requires("onetbb/[>=2021.5 <2024]")
            self.requires("zlib/[>=1.2.11 <2]")
        if self.options.studies:
            self.requires("fmt/[>=9 <13]")
            self.requires("nlohmann_json/[>=3.11 <4]", visible=False)

    def system_requirements(self):
        # Headers, needed to build only, which no recipe provides.
        if not self.options.kernels_only:
            Apt(self).install(["librandom123-dev"])

    def validate(self):
        if self.settings.os != "Linux" or self.settings.compiler not in ("gcc", "clang"):
            raise ConanInvalidConfiguration("consimd is built with gcc or clang on Linux")
        check_min_cppstd(self, 20)
        if self.options.studies and self.options.kernels_only:
            raise ConanInvalidConfiguration("studies need the solvers: kernels_only leaves them out")

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["CONSIMD_KERNELS_ONLY"] = bool(self.options.kernels_only)
        toolchain.cache_variables["CONSIMD_BUILD_STUDIES"] = bool(self.options.studies)
        for part in ("CLI", "TESTS", "BENCHMARKS", "EXAMPLES"):
            toolchain.cache_variables[f"CONSIMD_BUILD_{part}"] = False
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        rmdir(self, os.path.join(self.package_folder, "share"))

    def package_info(self):
        # CMake's users get the package that the library installs, others what follows.
        self.cpp_info.set_property("cmake_find_mode", "none")
        needs = {"kernels": []}
        if not self.options.kernels_only:
            needs["poses"] = ["kernels", "eigen::eigen"]
            needs["solvers"] = ["poses", "onetbb::onetbb"]
            needs["features"] = ["solvers", "onetbb::onetbb", "zlib::zlib"]
            needs["synth"] = ["poses"]
        if self.options.studies:
            needs["studies"] = ["features", "solvers", "synth", "fmt::fmt", "nlohmann_json::nlohmann_json"]
        for name, requires in needs.items():
            component = self.cpp_info.components[name]
            component.libs = [f"consimd_{name}"]
            component.requires = requires
            component.set_property("pkg_config_name", f"consimd-{name}")
        self.cpp_info.components["kernels"].builddirs = [os.path.join("lib", "cmake", "consimd")]
        # Used inside the library only; Conan wants every requirement named.
        self.cpp_info.components["kernels"].requires.append("xsimd::xsimd")
