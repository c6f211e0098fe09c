"""Help, version, info, and wrong usage."""

import json
import unittest

from command import CommandTest

COMMANDS = ["register", "match", "compare", "sweep", "merge", "generate", "info"]


class Usage(CommandTest):
    def test_help_explains_every_command(self):
        overview = self.run_command("--help")
        for command in COMMANDS:
            self.assertIn(command, overview)
            self.assertIn("--help", self.run_command(command, "--help"))
        for text in ["--noise-bound", "in the file's unit", "Examples:", "Exit code:"]:
            self.assertIn(text, self.run_command("register", "--help"))

    def test_version(self):
        self.assertRegex(self.run_command("--version"), r"\Aconsimd \d+\.\d+\.\d+\n\Z")

    def test_info(self):
        info = json.loads(self.run_command("info", "--json"))
        self.assertEqual(
            list(info),
            ["version", "commit", "compiler", "flags", "build_type", "cpu", "system", "isas", "isa", "threads",
             "solvers"],
        )
        self.assertEqual(info["isas"][0], "scalar")
        self.assertIn(info["isa"], info["isas"])
        self.assertIn("tcf", info["solvers"])
        text = self.run_command("info")
        for value in (info["version"], info["compiler"], info["isa"]):
            self.assertIn(value, text)

    def test_info_shows_the_chosen_isa(self):
        for isa in self.isas():
            self.assertEqual(json.loads(self.run_command("info", "--json", CONSIMD_ISA=isa))["isa"], isa)

    def test_wrong_usage(self):
        self.assert_error(says="expected a command")
        self.assert_error("nonsense", says="nonsense")
        self.assert_error("info", "--nonsense", says="--nonsense")

    def test_unknown_isa(self):
        for command in (
            ["info"],
            ["sweep", "--out", "sweep"],
            ["register", self.write("c.txt", "1 2 3 4 5 6\n" * 3), "--noise-bound", 1],
        ):
            self.assert_error(*command, says="sse9", CONSIMD_ISA="sse9")

    def test_help_and_errors_name_the_same_isas(self):
        _, error = self.start("info", CONSIMD_ISA="sse9").communicate(timeout=300)
        names = error.strip().partition("expected one of ")[2]
        self.assertLessEqual(set(self.isas()), set(names.split(", ")))
        self.assertIn(f"the instruction set to run on: {names} (", self.run_command("--help"))


if __name__ == "__main__":
    unittest.main()
