"""consimd generate."""

import fcntl
import json
import unittest

from command import CommandTest


class Generate(CommandTest):
    def test_writes_a_whole_problem(self):
        self.run_command("generate", "--points", 200, "--outliers", 0.75, "--sigma", 0.5, "--out", "a/b")
        folder = self.folder / "a/b"
        self.assertEqual(
            {path.name for path in folder.iterdir()}, {"correspondences.txt", "pose.txt", "labels.txt", "case.json"}
        )
        labels = [int(line) for line in (folder / "labels.txt").read_text().split()]
        self.assertEqual((len(labels), sum(labels)), (200, 50))
        case = json.loads((folder / "case.json").read_text())
        self.assertEqual(case["correspondences"], 200)
        self.assertEqual(case["noise_bound"], 1.5)
        self.assertAlmostEqual(case["inliers_within_noise_bound"], 50, delta=10)
        self.assertAlmostEqual(case["max_translation_error_m"], 0.5 * 6**0.5)
        self.assertGreater(case["max_rotation_error_deg"], 0)

    def test_same_options_same_bytes(self):
        for folder, trial in (("a", 3), ("b", 3), ("c", 4)):
            self.run_command("generate", "--points", 50, "--trial", trial, "--out", folder)
        a, b, c = ((self.folder / name / "correspondences.txt").read_bytes() for name in "abc")
        self.assertEqual(a, b)
        self.assertNotEqual(a, c)

    def test_follows_no_link_that_lies_in_wait(self):
        self.write("victim", "precious")
        (self.folder / "p").mkdir()
        for name in ("correspondences.txt", "pose.txt", "labels.txt", "case.json"):
            for link in (name, f"{name}.partial", f".{name}.part"):
                (self.folder / "p" / link).symlink_to("../victim")
        self.run_command("generate", "--points", 50, "--out", "p")
        self.assertEqual((self.folder / "victim").read_text(), "precious")

    def test_removes_what_a_killed_process_left_and_nothing_else(self):
        self.run_command("generate", "--points", 50, "--out", "p")
        whole = self.files().keys()
        left = self.folder / "p/.consimd-0123456789abcdef.part"
        left.write_text("half")
        (self.folder / "p/.consimd-notes.part").write_text("of somebody else")
        in_use = self.folder / "p/.consimd-fedcba9876543210.part"
        with open(in_use, "w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.run_command("generate", "--points", 50, "--out", "p")
        self.assertFalse(left.exists())
        self.assertEqual(self.files().keys() - whole, {in_use, self.folder / "p/.consimd-notes.part"})

    def test_bad_options(self):
        self.assert_error("generate", says="--out")
        for ratio in ("1", "-0.1", "nan", "0.9999", "x"):
            self.assert_error("generate", "--out", "p", "--outliers", ratio, says="outliers")
        for sigma in ("0", "-1", "nan", "inf", "1e308"):
            self.assert_error("generate", "--out", "p", "--sigma", sigma, says="sigma")
        for scale in ("0", "-1", "nan", "inf", "1e-308"):
            self.assert_error("generate", "--out", "p", "--scale", scale, says="scale")
        for option, values in {
            "--points": ["2", "-5", "99999999999", "x"],
            "--seed": ["-1"],
            "--trial": ["-1", "0.5"],
        }.items():
            for value in values:
                self.assert_error("generate", "--out", "p", option, value, says=option.strip("-"))
        self.write("file", "")
        for folder in ("file", "file/p"):
            self.assert_error("generate", "--out", folder, says="cannot write")


if __name__ == "__main__":
    unittest.main()
