"""Running the consimd command in tests."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from plotter import PLOTTER  # noqa: E402, F401  # for the tests that draw

CONSIMD = os.environ["CONSIMD"]
# How long a command may take; under a sanitizer many times what it takes otherwise.
MOST_SECONDS = float(os.environ.get("CONSIMD_TEST_SECONDS", "300"))


class CommandTest(unittest.TestCase):
    """A test with a folder of its own, self.folder, in which commands run."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        # Figures take a second each and need matplotlib: tests draw with a script that only leaves a mark, by a Python that
        # claims to have it.
        tools = tempfile.TemporaryDirectory()
        self.addCleanup(tools.cleanup)
        self.script = pathlib.Path(tools.name) / "plot.py"
        self.script.write_text("import sys; open(sys.argv[1] + '/drawn', 'w')\n")
        self.plotter = self.script.parent / "python"
        self.plotter.write_text(f'#!/bin/sh\n[ "$3" = "import matplotlib" ] || exec {sys.executable} "$@"\n')
        self.plotter.chmod(0o700)
        self.environment = {
            **{key: value for key, value in os.environ.items() if key != "CONSIMD_ISA"},
            "CONSIMD_PYTHON": str(self.plotter),
            "CONSIMD_PLOT_SCRIPT": str(self.script),
        }

    def draw_for_real(self):
        """From here on with the project's scripts, by PLOTTER."""
        del self.environment["CONSIMD_PLOT_SCRIPT"]
        self.environment["CONSIMD_PYTHON"] = PLOTTER

    def start(self, *arguments, **environment):
        return subprocess.Popen(
            [CONSIMD, *map(str, arguments)],
            cwd=self.folder,
            env={**self.environment, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run_command(self, *arguments, code=0, **environment):
        """Standard output of a command that must exit with `code`."""
        process = self.start(*arguments, **environment)
        out, err = process.communicate(timeout=MOST_SECONDS)
        self.assertEqual(process.returncode, code, f"{arguments}: {out}{err}")
        return out

    def assert_error(self, *arguments, says, **environment):
        """The command must exit with 2 and one line on stderr that holds `says`, and leave every file as it was."""
        before = self.files()
        process = self.start(*arguments, **environment)
        out, err = process.communicate(timeout=MOST_SECONDS)
        self.assertEqual((process.returncode, out), (2, ""), f"{arguments}: {out}{err}")
        self.assertRegex(err, r"\Aconsimd: [^\n]+\n\Z", arguments)
        self.assertIn(says, err)
        self.assertEqual(self.files(), before, arguments)

    def files(self):
        return {path: path.is_file() and path.read_bytes() for path in self.folder.rglob("*")}

    def write(self, name, text):
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    def isas(self):
        import json

        return json.loads(self.run_command("info", "--json"))["isas"]
