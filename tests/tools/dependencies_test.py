"""The bounds of versions: cmake/dependencies.txt, what else names them, and what shows and enforces them."""

import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROWS = [
    line.split() for line in (ROOT / "cmake/dependencies.txt").read_text().splitlines() if line and not line.startswith("#")
]
BOUNDS = {name: (at_least, below) for name, _, at_least, below, _ in ROWS}


class Bounds(unittest.TestCase):
    def test_pyproject_and_lint_ask_for_the_same(self):
        text = (ROOT / "pyproject.toml").read_text() + (ROOT / "tools/lint.sh").read_text()
        asked = re.findall(r"""["']([\w-]+)>=([\d.]+),<([\d.]+)["']""", text)
        self.assertEqual(
            {name: (at_least, below) for name, at_least, below in asked},
            {name: BOUNDS[name] for name, package, *_ in ROWS if package == "pip"},
        )

    def test_the_conan_recipe_asks_for_the_same(self):
        names = {"eigen": "Eigen3", "onetbb": "TBB", "zlib": "ZLIB"}
        asked = re.findall(r'requires\("(\w+)/\[>=(\S+) <(\S+)\]"', (ROOT / "packaging/conan/conanfile.py").read_text())
        self.assertGreaterEqual(len(asked), 6)
        for name, at_least, below in asked:
            self.assertEqual((at_least, below), BOUNDS[names.get(name, name)], name)


class Configuring(unittest.TestCase):
    def check(self, name, version, *settings):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "check.cmake"
            script.write_text(
                f'include({ROOT}/cmake/ConsimdDependencies.cmake)\nconsimd_check_version({name} "{version}")\n'
            )
            return subprocess.run(["cmake", *settings, "-P", script], capture_output=True, text=True, check=False)

    def test_versions_within_the_bounds_are_taken(self):
        for version in ("3.4", "3.4.0", "5.0.1", "5.99", ""):
            run = self.check("Eigen3", version)
            self.assertEqual(run.returncode, 0, run.stderr)

    def test_others_are_refused_by_name_unless_all_are_wanted(self):
        for version in ("3.3.9", "6", "6.0.0"):
            run = self.check("Eigen3", version)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn(f"Eigen3 {version} was found", run.stderr)
            self.assertEqual(self.check("Eigen3", version, "-DCONSIMD_CHECK_VERSIONS=OFF").returncode, 0)

    def test_a_dependency_without_bounds_is_an_error(self):
        self.assertIn("no bounds for Boost", self.check("Boost", "1.74").stderr)


class Listing(unittest.TestCase):
    def run_check(self, version):
        """`deps --check` where dpkg-query says that every package has the version."""
        with tempfile.TemporaryDirectory() as folder:
            query = pathlib.Path(folder) / "dpkg-query"
            query.write_text(f"#!/bin/sh\necho {version}\n")
            query.chmod(0o755)
            return subprocess.run(
                [ROOT / "dev", "deps", "--check"],
                capture_output=True, text=True, check=False, env={"PATH": f"{folder}:/usr/bin:/bin"},
            )

    def test_tells_tested_versions_from_others(self):
        lines = {line.split()[0]: line for line in self.run_check("2:3.4.0-4+deb12u1").stdout.splitlines()}
        self.assertLessEqual(set(BOUNDS), set(lines))
        self.assertRegex(lines["Eigen3"], r"3\.4\.0 +>=3\.4,<6 +3\.4\.0 +tested$")
        self.assertRegex(lines["CLI11"], "out of bounds$")
        later = {line.split()[0]: line for line in self.run_check("3.12.0-1").stdout.splitlines()}
        self.assertRegex(later["nlohmann_json"], "not tested$")

    def test_fails_where_one_is_out_of_bounds(self):
        run = self.run_check("0.1-1")
        self.assertEqual(run.returncode, 1)
        self.assertIn("out of bounds", run.stderr)


if __name__ == "__main__":
    unittest.main()
