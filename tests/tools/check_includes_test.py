"""tools/check_includes.py: this tree abides by the tables, and faults are found."""

import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from check_includes import POSIX, ROOMS, Rooms, layer_faults, posix_faults  # noqa: E402


class CheckIncludes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, path, text=""):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def test_this_tree_has_no_faults(self):
        rooms = Rooms(ROOT)
        self.assertEqual([*layer_faults(ROOT), *posix_faults(ROOT), *rooms.faults], [])
        self.assertEqual(len(list(rooms.graph())), len(ROOMS))

    def test_a_layer_may_not_include_one_above(self):
        self.write("kernels/src/a.cpp", '#include <consimd/kernels/isa.hpp>\n#include <consimd/solvers/tcf.hpp>\n')
        (fault,) = layer_faults(self.root)
        self.assertTrue(fault.startswith("kernels/src/a.cpp:2: includes consimd/solvers/tcf.hpp"), fault)

    def test_posix_is_called_in_the_listed_sources_alone(self):
        for header in ("unistd.h", "sys/stat.h", "signal.h"):
            self.write("solvers/src/call/a.cpp", f"#include <csignal>\n#include <{header}>\n")
            (fault,) = posix_faults(self.root)
            self.assertTrue(fault.startswith(f"solvers/src/call/a.cpp:2: includes {header}; POSIX is called in"), fault)
        self.write("solvers/src/call/a.cpp")
        for source in POSIX:
            self.assertTrue((ROOT / source).exists(), f"{source} is listed and not there")
            self.write(source, "#include <unistd.h>\n")
        self.assertEqual(list(posix_faults(self.root)), [])

    def test_a_folder_of_a_layers_own_may_have_the_name_of_another(self):
        self.write("synth/src/studies/a.hpp")
        self.write("synth/src/b.cpp", '#include "studies/a.hpp"\n')
        self.assertEqual(list(layer_faults(self.root)), [])

    def test_a_room_may_include_only_what_the_table_lets_it(self):
        self.write("solvers/src/ransac/a.cpp", '#include "support/points.hpp"\n#include "tcf/b.hpp"\n')
        (fault,) = Rooms(self.root).faults
        self.assertTrue(fault.startswith("solvers/src/ransac/a.cpp:2: includes tcf/b.hpp; room ransac"), fault)

    def test_a_public_header_belongs_to_the_room_of_its_source(self):
        self.write("solvers/include/consimd/solvers/tcf.hpp")
        self.write("solvers/src/tcf/tcf.cpp", "#include <consimd/solvers/tcf.hpp>\n")
        self.write("solvers/src/ransac/a.cpp", "#include <consimd/solvers/tcf.hpp>\n")
        (fault,) = Rooms(self.root).faults
        self.assertIn("solvers/src/ransac/a.cpp:1", fault)
        self.write("solvers/include/consimd/solvers/nowhere.hpp")
        self.assertTrue(any("no room has a source" in fault for fault in Rooms(self.root).faults))

    def test_a_circle_is_told(self):
        self.write("solvers/src/verdict/a.hpp", '#include "search/b.hpp"\n')
        self.write("solvers/src/search/b.hpp", '#include "verdict/a.hpp"\n')
        self.assertIn("search -> verdict", Rooms(self.root).faults[-1])

    def test_a_room_that_the_table_lacks_is_told(self):
        self.write("solvers/src/misc/a.cpp")
        (fault,) = Rooms(self.root).faults
        self.assertIn("solvers/src/misc", fault)


if __name__ == "__main__":
    unittest.main()
