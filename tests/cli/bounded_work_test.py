"""Input without a pose ends every solver in bounded time."""

import json
import random
import resource
import unittest

from command import MOST_SECONDS, CommandTest

ROWS = 5000
# Seconds of processor time. Some two seconds are what it takes; the rest is for a slow or busy machine, and more of it for
# a sanitizer.
MOST_PROCESSOR_SECONDS = MOST_SECONDS / 15


class BoundedWork(CommandTest):
    def solvers(self):
        return json.loads(self.run_command("info", "--json"))["solvers"]

    def register(self, solver, file, noise_bound):
        """Status of a run, whose processor time must be bounded. It must find no pose."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        out = self.run_command(
            "register", file, "--noise-bound", noise_bound, "--solver", solver, "--json", "-", "--threads", 2, code=1
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.assertLess(after.ru_utime - before.ru_utime, MOST_PROCESSOR_SECONDS, (solver, file))
        return json.loads(out)["runs"][0]["status"]

    def test_uniform_outliers_of_any_density(self):
        for sigma in (0.5, 5, 15):
            self.run_command("generate", "--points", ROWS, "--outliers", 0.9994, "--sigma", sigma, "--out", f"s{sigma}")
            for solver in self.solvers():
                status = self.register(solver, f"s{sigma}/correspondences.txt", 3 * sigma)
                self.assertEqual(status, "no_consensus", (solver, sigma))

    def test_input_that_determines_no_pose(self):
        draw = random.Random(1)
        along = [draw.uniform(-100, 100) for _ in range(ROWS)]
        clouds = {
            "point": [(1, 2, 3, 4, 5, 6)] * ROWS,
            "line": [(t, 2 * t, 3 * t, t, 2 * t, 3 * t) for t in along],
        }
        for name, rows in clouds.items():
            self.write(name, "".join(" ".join(map(repr, row)) + "\n" for row in rows))
            for solver in self.solvers():
                self.assertNotEqual(self.register(solver, name, 0.3), "success", (solver, name))


if __name__ == "__main__":
    unittest.main()
