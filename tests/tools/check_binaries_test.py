"""What tools/check_binaries.py finds in binaries made for it."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/check_binaries.py"
COMPILER = os.environ.get("CONSIMD_COMPILER", "c++")
HARDENED = ("-O2", "-fPIE", "-pie", "-fstack-protector-all", "-Wl,-z,relro", "-Wl,-z,now")


@unittest.skipUnless(shutil.which("readelf"), "no readelf")
class CheckBinaries(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "main.cpp").write_text("int main() {}\n")

    def link(self, *flags):
        subprocess.run([COMPILER, *flags, "main.cpp", "-o", "program"], cwd=self.folder, check=True)

    def faults(self, *options):
        run = subprocess.run(
            [sys.executable, SCRIPT, *options, self.folder], capture_output=True, text=True, check=False
        )
        self.assertEqual(run.returncode, 1 if run.stderr else 0, run.stderr)
        return [line.removeprefix(f"{self.folder}/program: ") for line in run.stderr.splitlines()]

    def test_entries_that_are_the_current_folder(self):
        for entries, bad in (("/usr/lib:$ORIGIN/../lib:$ORIGIN", []), ("/usr/lib:", [""]), ("::", ["", "", ""]),
                             ("lib:/usr/lib:./x", ["lib", "./x"])):  # fmt: skip
            for tags, name in (("--enable-new-dtags", "RUNPATH"), ("--disable-new-dtags", "RPATH")):
                self.link(f"-Wl,-rpath,{entries},{tags}")
                self.assertEqual(
                    self.faults(),
                    [f"{name} {entries} has the entry '{e}', which is or lies in the current folder" for e in bad],
                )

    def test_hardening(self):
        self.link(*HARDENED)
        self.assertEqual(self.faults("--hardened"), [])
        self.link(*HARDENED, "-Wl,-z,lazy")
        self.assertEqual(self.faults("--hardened"), ["no full RELRO"])
        self.link(*HARDENED, "-Wl,-z,norelro")
        self.assertEqual(self.faults("--hardened"), ["no full RELRO"])
        self.link(*HARDENED, "-fno-stack-protector")
        self.assertEqual(self.faults("--hardened"), ["no stack protector"])
        self.link(*HARDENED, "-fno-PIE", "-no-pie")
        self.assertEqual(self.faults("--hardened"), ["not position-independent"])

    def test_functions_that_round_in_their_own_way(self):
        (self.folder / "main.cpp").write_text(
            "#include <cmath>\n"
            "int main(int n, char**) { volatile double x = n; volatile float y = 1.0F;\n"
            "  return std::log1p(x) + std::pow(x, x) + std::atan2(x, x) + std::sin(y) > 2.0; }\n"
        )
        self.link()
        self.assertEqual(
            self.faults("--reproducible"),
            [f"calls {name} of the C library, whose results differ between processors" for name in
             ("atan2", "log1p", "pow", "sinf")],
        )  # fmt: skip
        self.assertEqual(self.faults(), [])
        (self.folder / "main.cpp").write_text(
            "#include <cmath>\n"
            "int main(int n, char**) { volatile double x = n, y = 3;\n"
            "  return std::sqrt(x) + std::floor(x) + std::fmod(x, y) + std::ldexp(x, n) + std::round(x) > 9.0; }\n"
        )
        self.link()
        self.assertEqual(self.faults("--reproducible"), [])

    def test_nothing_to_check_is_a_fault(self):
        self.assertEqual(self.faults(), [f"no binaries in {self.folder}"])


if __name__ == "__main__":
    unittest.main()
