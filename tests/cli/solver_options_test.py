"""Options of solvers: --option, NAME:OPTION=VALUE, info --solver."""

import csv
import json
import pathlib
import re
import subprocess
import sys
import unittest

from command import CONSIMD, CommandTest

ROOT = pathlib.Path(__file__).resolve().parents[2]

BAD = {  # solver, option: values, what was expected
    ("ransac", "max_iterations"): (["", "x", "0", "-1", "1.5", "nan", "4294967296"], "a whole number from 1 to 4294967295"),
    ("tcf", "confidence"): (["", "x", "0", "1", "nan", "inf", "none"], "a number above 0 and below 1"),
    ("ransac", "confidence"): (["", "off", "nan"], "a number above 0 and below 1, or none"),
    ("teaser", "refine"): (["", "1", "True"], "true or false"),
    ("sc2_pcr", "ranking"): (["", "best", "nan"], "one of: inlier_count, truncated_score"),
}


class SolverOptions(CommandTest):
    def names(self):
        return json.loads(self.run_command("info", "--json"))["solvers"]

    def info(self, solver):
        return json.loads(self.run_command("info", "--solver", solver, "--json"))

    def problem(self):
        self.run_command("generate", "--points", 400, "--outliers", 0.8, "--sigma", 0.1, "--out", "p")
        return "p/correspondences.txt"

    def register(self, *arguments, code=0):
        return json.loads(self.run_command("register", *arguments, "--json", "-", code=code))

    def test_info_tells_of_every_solver(self):
        for name in self.names():
            info = self.info(name)
            self.assertEqual(info["name"], name)
            text = self.run_command("info", "--solver", name)
            for option in info["options"]:
                self.assertTrue(option["meaning"] and option["expected"])
                self.assertIn(f"  {option['name']}=", text)
                self.assertIn(option["meaning"], text)
                self.assertIn(option["expected"], text)
        self.assertEqual(self.info("ransac-10k")["solver"], "ransac")
        values = {option["name"]: option["value"] for option in self.info("ransac-10k")["options"]}
        self.assertEqual((values["max_iterations"], values["confidence"]), (10000, None))
        self.assertIn("preset       ransac-10k: ", self.run_command("info", "--solver", "ransac"))
        self.assert_error("info", "--solver", "magic", says="solver is 'magic', expected one of: tcf, ")
        self.assert_error("info", "--solver", "", says="expected one of: tcf, ")

    def test_the_pages_say_the_same(self):
        page = subprocess.check_output([sys.executable, ROOT / "tools/solver_options_page.py", CONSIMD], text=True)
        self.assertEqual(page, (ROOT / "docs/solver_options.md").read_text())
        # The columns of the table of solvers that are not measured.
        rows = re.findall(r"^\| `([\w-]+)` \| (.*) \|$", (ROOT / "docs/solvers.md").read_text(), re.MULTILINE)
        table = {name: cells.split(" | ") for name, cells in rows if cells.count(" | ") == 5}
        infos = [self.info(name) for name in self.names()]
        solvers = {info["name"]: info for info in infos if info["name"] == info["solver"]}
        self.assertEqual(table.keys(), solvers.keys())
        for name, (needs, memory, _, _, stops_early, advice) in table.items():
            for key, cell in (("needs", needs), ("memory", memory), ("stops_early", stops_early), ("advice", advice)):
                self.assertEqual(cell, solvers[name][key] or "nothing", f"{name}: {key}")

    def test_help_lists_the_solvers(self):
        listed = " ".join(self.run_command("register", "--help").split())
        self.assertIn(", ".join(self.names()), listed)

    def test_every_option_can_be_given(self):
        file = self.problem()
        for name in self.names():
            code = int(name == "tcf-published")  # no pose: the clouds are rotated against each other
            plain = self.register(file, "--noise-bound", 0.3, "--solver", name, code=code)
            self.assertNotIn("options", plain)
            options = {o["name"]: o["value"] for o in self.info(name)["options"]}
            given = []
            for option, value in options.items():
                given += ["--option", f"{option}={'none' if value is None else json.dumps(value).strip(chr(34))}"]
            same = self.register(file, "--noise-bound", 0.3, "--solver", name, *given, code=code)
            self.assertEqual((same["solver"], same["options"]), (name, options))
            for key in ("T_target_source", "inliers", "log10_false_poses"):
                self.assertEqual(same["runs"][0][key], plain["runs"][0][key])

    def test_options_reach_the_solver(self):
        file = self.problem()
        iterations = lambda *arguments: self.register(file, "--noise-bound", 0.3, *arguments)["runs"][0]["stages"][0][
            "iterations"
        ]
        exactly = ("--option", "max_iterations=700", "--option", "confidence=none")
        self.assertEqual(iterations("--solver", "ransac", *exactly), 700)
        self.assertEqual(iterations("--solver", "ransac:max_iterations=800:confidence=none"), 800)
        self.assertEqual(iterations("--solver", "ransac-10k"), 10000)
        self.assertEqual(iterations("--solver", "ransac-10k:max_iterations=900"), 900)
        self.assertEqual(iterations("--solver", "ransac:confidence=none", "--option", "max_iterations=900"), 900)
        text = self.run_command("register", file, "--noise-bound", 0.3, "--solver", "ransac", *exactly)
        self.assertIn("ransac:max_iterations=700:confidence=none", text)

    def test_scale_is_an_option_too(self):
        self.run_command("generate", "--points", 600, "--outliers", 0.9, "--sigma", 0.1, "--scale", 0.5, "--out", "s")
        file = ("s/correspondences.txt", "--noise-bound", 0.3, "--solver", "teaser", "--truth", "s/pose.txt")
        by_option = self.register(*file, "--option", "estimate_scale=true")
        by_flag = self.register(*file, "--estimate-scale")
        self.assertIs(by_option["estimate_scale"], True)
        self.assertLess(by_option["runs"][0]["scale_error"], 0.01)
        for key in ("T_target_source", "scale", "scale_deviation", "inliers"):
            self.assertEqual(by_option["runs"][0][key], by_flag["runs"][0][key])

    def test_bad_options(self):
        file = self.write("good.txt", "1 2 3 4 5 6\n" * 5)
        commands = {
            "register": ["register", file, "--noise-bound", 1],
            "sweep": ["sweep", "--out", "s"],
            "compare": ["compare", "--synthetic", "arch", "--out", "c"],
        }
        for command in commands.values():
            for (solver, option), (values, expected) in BAD.items():
                for value in values:
                    setting = f"{option}={value}"
                    says = f"{option} is "
                    self.assert_error(*command, "--solver", solver, "--option", setting, says=f"--option: {says}")
                    self.assert_error(*command, "--solver", f"{solver}:{setting}", says=says)
                    self.assert_error(*command, "--solver", f"{solver}:{setting}", says=f"expected {expected}")
            there = "solver 'tcf' has no option 'max_nodes', expected one of: confidence, max_seeds"
            self.assert_error(*command, "--solver", "tcf", "--option", "max_nodes=1", says=there)
            self.assert_error(*command, "--solver", "tcf:max_nodes=1", says=there)
            self.assert_error(*command, "--solver", "tcf", "--option", "=1", says="has no option ''")
            self.assert_error(*command, "--solver", "tcf", "--option", "", says="has no option ''")
            self.assert_error(*command, "--solver", "tcf", "--option", "max_seeds", says="max_seeds=10000 or another")
            twice = ("--option", "max_seeds=1")
            self.assert_error(*command, "--solver", "tcf", *twice, *twice, says="'max_seeds' of solver 'tcf' is given twice")
            self.assert_error(*command, "--solver", "tcf:max_seeds=1", *twice, says="is given twice")
            self.assert_error(*command, "--option", says="--option")
        for command in (commands["sweep"], commands["compare"]):
            some = ("--solver", "ransac,tcf", "--option", "max_seeds=1")
            self.assert_error(*command, *some, says="solver 'ransac' has no option 'max_seeds'")
            self.assert_error(*command, "--solver", "tcf:max_seeds=01,tcf:max_seeds=1", says="is given twice")

    def test_values_that_do_not_go_together(self):
        file = self.write("some.txt", "1 2 3 4 5 6\n" * 5)
        self.assert_error("register", file, "--noise-bound", 1, "--solver", "sc2_pcr:first_set=10", says="second_set is 20")

    def rows(self, path):
        with open(self.folder / path) as file:
            return list(csv.DictReader(file))

    def test_a_study_knows_its_options(self):
        small = ["sweep", "--points", 200, "--outliers", 0.5, "--sigma", 1, "--trials", 2, "--out", "s"]
        solvers = ["--solver", "ransac:confidence=none:max_iterations=0500,ransac,tcf"]
        self.run_command(*small, *solvers)
        label = "ransac:max_iterations=500:confidence=none"
        self.assertEqual([row["solver"] for row in self.rows("s/cells.csv")], [label, "ransac", "tcf"])
        summary = json.loads((self.folder / "s/summary.json").read_text())
        self.assertEqual(summary["options"]["solver"], [label, "ransac", "tcf"])
        # The same study, told in other words.
        again = ["--solver", "ransac:max_iterations=500:confidence=none,ransac,tcf"]
        self.assertIn("6 done before", self.run_command(*small, *again))
        self.assert_error(*small, "--solver", "ransac:max_iterations=501:confidence=none,ransac,tcf", says="another study")
        self.run_command(*small, "--fresh", "--solver", "ransac", "--option", "max_iterations=500", "--option",
                         "confidence=none")
        self.assertEqual({row["solver"] for row in self.rows("s/trials.csv")}, {label})
        self.assert_error(*small, "--solver", "ransac", says="another study")

    def test_a_comparison_knows_its_options(self):
        small = ["compare", "--synthetic", "arch", "--trials", 1, "--table", "solvers,boost", "--out", "c"]
        self.run_command(*small, "--solver", "ransac:max_iterations=500,tcf")
        self.assertEqual(
            [row["method"] for row in self.rows("c/runs.csv")][:3],
            ["ransac:max_iterations=500", "tcf+ransac:max_iterations=500", "tcf"],
        )
        self.assertEqual(self.rows("c/table_solvers.csv")[0]["solver"], "ransac:max_iterations=500")
        summary = json.loads((self.folder / "c/comparison.json").read_text())
        self.assertEqual(summary["options"]["solver"], "ransac:max_iterations=500,tcf")
        self.assert_error(*small, "--solver", "ransac:max_iterations=501,tcf", says="another comparison")
        scales = ["compare", "--table", "scales", "--scales", 0.5, "--trials", 1, "--out", "d"]
        self.run_command(*scales, "--solver", "teaser:refine=false,teaser")
        self.assertEqual([row["solver"] for row in self.rows("d/table_scales.csv")], ["teaser:refine=false", "teaser"])


if __name__ == "__main__":
    unittest.main()
