"""What consimd register refuses: files, and options that are wrong or do not go together."""

import unittest

from command import CommandTest


class RegisterErrors(CommandTest):
    def test_bad_files(self):
        good = "1 2 3 4 5 6\n" * 5
        for text, says in (
            ("", "bad.txt: is empty, expected lines of numbers"),
            ("# nothing\n\n", "got 0"),
            ("1 2 3 4 5 6\n" * 2, "bad.txt: expected at least 3 correspondences, got 2: a pose needs three"),
            ("1\n" * 9, "bad.txt:1: expected 6 numbers, got 1: a correspondence is a line of source x y z and target x y z"),
            (good + "1;;2;3;4;5;6\n", "bad.txt:6: column 2 is empty, between two semicolons: fill it in or remove the line"),
            (good + "1,5 2 3 4 5 6\n", "bad.txt:6: '1,5' has a decimal comma: write decimal points, as 'tr , . < FILE' does"),
            ("1,5;2,5;3;4;5;6\n" * 5, "bad.txt:1: '1,5' is not a number: write decimal points, as 'tr , . < FILE' does"),

            (good + "1 2 3 4 5\n", "bad.txt:6: expected 6 numbers, got 5"),
            (good + "\n1 2 3 4 5 6 7\n", "bad.txt:7: expected 6 numbers, got 7"),
            (good + "1 2 three 4 5 6\n" + good, "bad.txt:6: 'three' is not a number"),
            (good + "1 2 nan 4 5 6\n", "bad.txt:6: 'nan' is not finite"),
            (good + "1 2 3 4 inf 6\n", "bad.txt:6: 'inf' is not finite"),
            (bytes(range(256)) * 4, "bad.txt: is binary or UTF-16 text"),
            (b"\x1f\x8b\x08\0", "bad.txt: is compressed by gzip, expected text: unpack it with 'gunzip'"),
            (b"\x93NUMPY\1\0", "bad.txt: is of NumPy or a zip archive"),
        ):
            file = self.write("bad.txt", text)
            self.assert_error("register", file, "--noise-bound", 1, "--json", "out.json", says=says)
        self.assert_error("register", "none.txt", "--noise-bound", 1, says="none.txt: cannot read: No such file")
        self.assert_error("register", "none.txt", "--noise-bound", "", says="--noise-bound: is empty, expected a number")
        self.assert_error("register", "none.txt", "--view", "view.png", says="expected a FILE.html, got 'view.png'")
        self.assert_error("register", ".", "--noise-bound", 1, says="is a folder")

    def test_bad_options(self):
        file = self.write("good.txt", "1 2 3 4 5 6\n" * 5)
        self.assert_error("register", "--noise-bound", 1, says="FILE")
        for bound in ("0", "-1", "nan", "inf", "-inf", "x", "1m"):
            self.assert_error("register", file, "--noise-bound", bound, says="--noise-bound")
            self.assert_error("register", file, "--noise-bound", bound, says=bound)
        self.assert_error("register", file, "--noise-bound", says="--noise-bound")
        unknown = "solver is 'magic', expected one of: tcf"
        self.assert_error("register", file, "--noise-bound", 1, "--solver", "magic", says=unknown)
        for option in ("--threads", "--repeat"):
            for value in ("0", "-1", "x", "1.5", "99999999999"):
                self.assert_error("register", file, "--noise-bound", 1, option, value, says=option)
        self.assert_error("register", file, "--noise-bound", 1, "--seed", "-1", says="--seed")
        for wrong in ("none", "rubbish", "1,2", ""):
            self.assert_error("register", file, "--source-viewpoint", wrong,
                              says=f"--source-viewpoint: expected X,Y,Z of correspondences, got '{wrong}'")
        for value in ("1,2,3", "0,0,0", "none", "rubbish"):
            self.assert_error("register", file, "--target-viewpoint", value,
                              says=f"--target-viewpoint {value} is of two clouds, SOURCE and TARGET")
        self.assert_error("register", file, "--voxel", 2, "--refine", "plane",
                          says="--voxel 2, --refine plane are of two clouds, SOURCE and TARGET, that are matched here")
        self.assert_error("register", file, file, "--pairs", "rows", "--voxel", 2,
                          says="--voxel 2 is of two clouds, SOURCE and TARGET, that are matched here; --pairs tells which")

    def test_outputs_that_cannot_be(self):
        file = self.write("good.txt", "1 2 3 4 5 6\n" * 5)
        for option in ("--save-aligned", "--view", "--picture", "--save-correspondences"):
            self.assert_error("register", file, file, option, "-", says=f"{option}: expected a file; only --json,")
        self.assert_error("register", file, "--save-pose", "out", "--save-inliers", "./out",
                          says="--save-inliers: './out' is written twice, by --save-pose too")
        self.assert_error("register", file, "--json", "out", "--save-pose", "out", says="'out' is written twice")
        self.assert_error("register", file, file, "--json", "out", "--save-correspondences", "out",
                          says="--save-correspondences: 'out' is written twice, by --json too")
        for first, second in (("--json", "--save-pose"), ("--json", "--save-inliers"), ("--save-pose", "--save-inliers")):
            self.assert_error("register", file, first, "-", second, "-", says=f"'-' is written twice, by {first} too")

    def test_outputs_that_are_inputs(self):
        text = "1 2 3 4 5 6\n" * 5
        file, other = self.write("good.txt", text), self.write("other.txt", text)
        for option in ("--save-pose", "--save-inliers", "--json", "--view"):
            self.assert_error("register", file, option, "./good.txt", says=f"{option}: './good.txt' is what FILE reads")
        self.assert_error("register", file, other, "--pairs", "rows", "--view", other, says="is what TARGET reads")
        self.write("pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n")
        (self.folder / "link.txt").symlink_to("pose.txt")
        self.assert_error("register", file, "--truth", "pose.txt", "--save-pose", "link.txt", says="is what --truth reads")
        self.assertEqual((self.folder / "good.txt").read_text(), text)

    def test_unwritable_json(self):
        file = self.write("good.txt", "1 2 3 4 5 6\n" * 5)
        for target in ("missing/out.json", "good.txt/out.json", "."):
            self.assert_error("register", file, "--noise-bound", 1, "--json", target, says="cannot write")

    def test_bad_truth(self):
        file = self.write("good.txt", "1 2 3 4 5 6\n" * 5)
        for text in ("", "1 0 0 0\n", "2 0 0 0\n0 2 0 0\n0 0 2 0\n", "1 0 0 0\n0 1 0 0\n0 0 -1 0\n", "a b c d\n"):
            self.write("pose.txt", text)
            self.assert_error("register", file, "--noise-bound", 1, "--truth", "pose.txt", says="pose.txt:")
        self.assert_error("register", file, "--noise-bound", 1, "--truth", "none", says="none: cannot read")


if __name__ == "__main__":
    unittest.main()
