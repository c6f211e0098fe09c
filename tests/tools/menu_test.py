"""The menu ./dev and the scripts in tools/ that it runs."""

import os
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def dev(*arguments):
    environment = {name: value for name, value in os.environ.items() if name != "CONSIMD_NO_INSTALL"}
    return subprocess.run([ROOT / "dev", *arguments], capture_output=True, text=True, check=False, env=environment)


class Menu(unittest.TestCase):
    def test_help_shows_what_every_script_says_of_itself(self):
        scripts = sorted((ROOT / "tools").glob("*.sh"))
        self.assertTrue(scripts)
        shown = dev("help").stdout.splitlines()
        for script in scripts:
            said = [line[3:] for line in script.read_text().splitlines() if line.startswith("#: ")]
            self.assertTrue(said and said[0].split()[0] == script.stem, f"{script.name} does not say what it does")
            for line in said:
                self.assertIn(f"  {line}", shown)

    def test_an_unknown_command_is_an_error_that_shows_the_menu(self):
        run = dev("sweeep")
        self.assertEqual(run.returncode, 1)
        self.assertIn("unknown command 'sweeep'", run.stderr)
        self.assertTrue(run.stderr.startswith("usage: ./dev"))

    def test_an_unknown_package_group_is_an_error_that_lists_them(self):
        run = dev("deps", "figurs")
        self.assertEqual(run.returncode, 1)
        self.assertIn("unknown package group 'figurs'; known: browser build docs figures fuzz lint neon python", run.stderr)


if __name__ == "__main__":
    unittest.main()
