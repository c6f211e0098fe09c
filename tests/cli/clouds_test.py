"""consimd match and consimd register of two clouds."""

import json
import math
import random
import struct
import unittest
import zipfile

from command import CommandTest


def room(seed, count=20000):
    """Points on the floor and two walls of a room with boxes; no two corners are alike."""
    draw = random.Random(seed)
    boxes = random.Random(1)
    corners = [[boxes.uniform(-4, 4), boxes.uniform(-4, 4), 0] for _ in range(12)]
    sizes = [[boxes.uniform(0.3, 1.2), boxes.uniform(0.3, 1.2), boxes.uniform(0.5, 2)] for _ in range(12)]
    points = []
    for _ in range(count):
        u, v = draw.random(), draw.random()
        kind = draw.randrange(5)
        if kind == 0:
            p = [10 * u - 5, 10 * v - 5, 0]
        elif kind == 1:
            p = [5, 10 * u - 5, 3 * v]
        elif kind == 2:
            p = [4 * u - 4, 5, 3 * v]
        else:
            box, side = draw.randrange(12), draw.randrange(3)
            share = [u, v, u]
            share[side], share[(side + 1) % 3], share[(side + 2) % 3] = 1, u, v
            p = [corners[box][c] + sizes[box][c] * share[c] for c in range(3)]
        points.append([x + draw.uniform(-0.01, 0.01) for x in p])
    return points


def npy(rows):
    """An array of float64 as NumPy writes it."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({len(rows)}, {len(rows[0])}), }}".ljust(117) + "\n"
    values = b"".join(struct.pack(f"<{len(row)}d", *row) for row in rows)
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(header)) + header.encode() + values


class Clouds(CommandTest):
    def clouds(self):
        """Two scans of the room, the target turned by 0.3 rad about z and moved; a PLY file and text."""
        source = b"".join(struct.pack("<3f", *p) for p in room(1))
        header = "ply\nformat binary_little_endian 1.0\nelement vertex 20000\n"
        header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
        (self.folder / "source.ply").write_bytes(header.encode() + source)
        c, s = math.cos(0.3), math.sin(0.3)
        lines = [f"{c * x - s * y + 1} {s * x + c * y - 0.5} {z}" for x, y, z in room(2)]
        (self.folder / "target.xyz").write_text("\n".join(lines + ["nan nan nan"]) + "\n")
        (self.folder / "pose.txt").write_text(f"{c} {-s} 0 1\n{s} {c} 0 -0.5\n0 0 1 0\n")
        return "source.ply", "target.xyz"

    def test_matched_clouds(self):
        """Points that are matched already, as two files, with pairs of rows, and as a learned matcher writes them."""
        points = room(1, 300)
        rows = [[x, y, z, 5 - y, 3 + x, z] for x, y, z in points]
        self.write("six.txt", "".join("{} {} {} {} {} {}\n".format(*row) for row in rows))
        self.write("a.csv", "x;y;z\n" + "".join("{};{};{}\n".format(*row[:3]) for row in rows))
        self.write("b.xyz", "".join("{} {} {}\n".format(*row[3:]) for row in rows))
        self.write("reversed.xyz", "".join("{} {} {}\n".format(*row[3:]) for row in reversed(rows)))
        self.write("pairs.txt", "# source target score\n" + "".join(f"{k} {299 - k} 0.9\n" for k in range(300)))
        arrays = {"src_corr_points.npy": [row[:3] for row in rows], "ref_corr_points.npy": [row[3:] for row in rows]}
        for name, method in (("stored.npz", zipfile.ZIP_STORED), ("deflated.npz", zipfile.ZIP_DEFLATED)):
            with zipfile.ZipFile(self.folder / name, "w", method) as archive:
                archive.writestr("corr_scores.npy", npy([[1.0]]))
                for array, values in arrays.items():
                    archive.writestr(array, npy(values))
        self.write("six.npy", npy(rows))
        self.write("named.txt", "".join("p{} {} {} {}\n".format(k, *row[:3]) for k, row in enumerate(rows)))
        self.write("pose.txt", "1 2 3\n0 -1 0 5\n1 0 0 3\n0 0 1 0\n0 0 0 1\n")

        def runs(*arguments):
            said = json.loads(
                self.run_command("register", *arguments, "--noise-bound", 0.1, "--truth", "pose.txt", "--json", "-")
            )
            return [{**run, "seconds": 0, "stages": 0} for run in said["runs"]]

        expected = runs("six.txt")
        self.assertEqual(expected[0]["inlier_count"], 300)
        self.assertLess(expected[0]["translation_error"], 1e-6)
        for arguments in (
            ["a.csv", "b.xyz", "--pairs", "rows"],
            ["a.csv", "reversed.xyz", "--pairs", "pairs.txt"],
            ["six.txt", "six.txt", "--pairs", "rows", "--columns", "1,2,3,4,5,6"],
            ["named.txt", "b.xyz", "--pairs", "rows", "--columns", "2,3,4,1,2,3"],
            ["named.txt", "reversed.xyz", "--pairs", "pairs.txt", "--columns", "2,3,4,1,2,3"],
            ["stored.npz"],
            ["deflated.npz"],
            ["six.npy"],
        ):
            self.assertEqual(runs(*arguments), expected, arguments)
        damaged = bytearray((self.folder / "deflated.npz").read_bytes())
        damaged[200] ^= 1
        self.write("damaged.npz", bytes(damaged))
        self.write("short.xyz", "1 2 3\n")
        self.write("beyond.txt", "0 0\n5 300\n")
        self.write("word.txt", "0 one\n")
        for arguments, says in (
            (["damaged.npz"], "damaged.npz: "),
            (["a.csv", "short.xyz", "--pairs", "rows"], "short.xyz: 1 rows, expected 300 as in a.csv"),
            (["a.csv", "b.xyz", "--pairs", "beyond.txt"], "beyond.txt:2: row 300 of the target, which has 300"),
            (["a.csv", "b.xyz", "--pairs", "word.txt"], "word.txt:1: 'one' is no row of the target"),
            (["a.csv", "b.xyz", "--pairs", "none.txt"], "none.txt: cannot read"),
            (["a.csv", "b.xyz", "--pairs", "rows", "--voxel", 1], "that are matched here"),
            (["six.txt", "--pairs", "rows"], "--pairs: needs two clouds"),
            (["named.txt", "b.xyz"], "named.txt:1: neither numbers nor a line of names with x, y and z: 'p0 "),
            (["named.txt", "b.xyz"], "say which are x, y and z, counted from 1"),
            (["a.csv", "b.xyz", "--columns", "1,2"], "--columns: expected three columns of both clouds"),
            (["a.csv", "b.xyz", "--columns", ""], "--columns: expected three columns of both clouds"),
            (["six.txt", "--columns", ""], "--columns: expected six columns"),
            (["a.csv", "b.xyz", "--columns", "0,1,2"], "--columns: expected three columns of both clouds"),
            (["a.csv", "b.xyz", "--columns", "-1,1,2"], "--columns: expected three columns of both clouds"),
            (["a.csv", "b.xyz", "--columns", "1,2,1"], "--columns: expected three columns of both clouds"),
            (["six.txt", "--columns", "1,2,3,4,5,5"], "--columns: expected six columns"),
            (["a.csv", "b.xyz", "--columns", "1,2,4"], "a.csv:2: expected 4 numbers or more, got 3"),
            (["six.npy", "b.xyz", "--columns", "1,2,3"], "six.npy: columns are chosen of plain text alone"),
            (["six.npy", "--columns", "4,5,6,1,2,3"], "--columns: chooses among the columns of text"),
            (["six.txt", "--columns", "1,2,3"], "--columns: expected six columns"),
            (["six.txt", "--columns", "1,2,3,4,5,7"], "column 7 of 6"),
        ):
            self.assert_error("register", *arguments, says=says)

    def test_columns_of_clouds(self):
        """Columns that are chosen give what columns in their order give."""
        for name, points in (("a", room(1, 2000)), ("b", room(2, 2000))):
            self.write(f"{name}.xyz", "".join("{} {} {}\n".format(*p) for p in points))
            self.write(f"{name}.txt", "".join("p{} {} {} {}\n".format(k, *p) for k, p in enumerate(points)))
        self.run_command("match", "a.xyz", "b.xyz", "--voxel", 0.2, "--out", "plain")
        self.run_command("match", "--columns", "2,3,4", "a.txt", "b.txt", "--voxel", 0.2, "--out", "chosen")
        self.run_command("match", "a.txt", "b.xyz", "--columns", "2,3,4,1,2,3", "--voxel", 0.2, "--out", "each")
        plain = (self.folder / "plain" / "correspondences.txt").read_text()
        self.assertGreater(plain.count("\n"), 100)
        for folder in ("chosen", "each"):
            self.assertEqual((self.folder / folder / "correspondences.txt").read_text(), plain)

    def test_farthest_keypoints(self):
        source, target = self.clouds()
        arguments = ["register", source, target, "--keypoints", "farthest:1500", "--json", "-"]
        result = json.loads(self.run_command(*arguments))
        self.assertEqual(result["runs"][0]["status"], "success")
        stages = {stage["name"]: stage["output"] for stage in result["clouds"]["stages"]}
        self.assertEqual(stages["farthest"], 3000)
        self.assertGreater(result["clouds"]["source"]["descriptors"], 1400)  # a few points are alone and have none
        self.assertEqual(json.loads(self.run_command(*arguments, "--threads", 2))["runs"][0]["inliers"],
                         result["runs"][0]["inliers"])  # fmt: skip
        for wrong in ("farthest", "farthest:0", "farthest:many"):
            self.assert_error("match", source, target, "--keypoints", wrong, says="farthest:COUNT")

    def test_register(self):
        source, target = self.clouds()
        result = json.loads(self.run_command("register", source, target, "--truth", "pose.txt", "--json", "-"))
        run = result["runs"][0]
        self.assertEqual(run["status"], "success")
        self.assertLess(run["rotation_error_deg"], 1)
        self.assertLess(run["translation_error"], 0.1)
        self.assertEqual(result["file"], "source.ply and target.xyz")
        clouds = result["clouds"]
        self.assertEqual((clouds["source"]["points"], clouds["target"]["left_out"]), (20000, 1))
        self.assertEqual([stage["name"] for stage in clouds["stages"]],
                         ["choose_voxel", "voxel_grid", "normals", "fpfh", "matches"])
        self.assertEqual((clouds["keypoints"], clouds["matches"]), ("random:5000", "mutual:3"))
        self.assertEqual((clouds["source_viewpoint"], clouds["target_viewpoint"]), ([0, 0, 0], [0, 0, 0]))
        self.assertNotIn("source_viewpoint", result)
        self.assertEqual(result["noise_bound"], run["noise_bound"])
        mean = (clouds["source"]["resolution"] + clouds["target"]["resolution"]) / 2
        self.assertAlmostEqual(result["noise_bound"], 3 * mean)
        text = self.run_command("register", source, target, "--voxel", 0.15, "--noise-bound", 0.2)
        self.assertIn("noise bound 0.2,", text)
        self.assertIn("voxel         0.15, keypoints random:5000, matches mutual:3", text)

    def test_viewpoints(self):
        """Clouds in map coordinates: where they were scanned from is told, or that it is nowhere."""
        source, target = self.clouds()
        moved = "".join(f"{x + 4e5} {y - 3e5} {z + 100}\n" for x, y, z in room(1))
        (self.folder / "map.xyz").write_text(moved)
        turned = [[float(x) for x in line.split()] for line in (self.folder / target).read_text().splitlines()[:-1]]
        (self.folder / "turned.xyz").write_text("".join(f"{x + 4e5} {y - 3e5} {z + 100}\n" for x, y, z in turned))
        for places in (("4e5,-3e5,101", "400001,-300000.5,101"), ("none", "none")):
            result = json.loads(self.run_command("register", "map.xyz", "turned.xyz", "--source-viewpoint", places[0],
                                                 "--target-viewpoint", places[1], "--json", "-"))
            told = [None if place == "none" else [float(x) for x in place.split(",")] for place in places]
            self.assertEqual([result["clouds"][f"{cloud}_viewpoint"] for cloud in ("source", "target")], told)
            (run,) = result["runs"]
            self.assertEqual(run["status"], "success", places)
            self.assertAlmostEqual(run["T_target_source"][0][0], math.cos(0.3), delta=0.02)
        for wrong in ("", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1;2;3", "None"):
            for option in ("--source-viewpoint", "--target-viewpoint"):
                self.assert_error("register", source, target, option, wrong,
                                  says=f"{option}: expected X,Y,Z or none, got '{wrong}'")
                self.assert_error("register", "absent.ply", target, option, wrong, says=f"{option}: expected X,Y,Z or none")

    def test_refine(self):
        source, target = self.clouds()
        arguments = ("register", source, target, "--voxel", 0.15, "--truth", "pose.txt", "--json", "-")
        plain = json.loads(self.run_command(*arguments))["runs"][0]
        self.assertNotIn("refinement", plain)
        for method in ("point", "plane", "gicp"):
            result = json.loads(self.run_command(*arguments, "--refine", method, "--save-pose", "refined.txt"))
            run = result["runs"][0]
            self.assertEqual((result["refine"], run["refinement"]["status"]), (method, "converged"))
            self.assertLess(run["translation_error"], plain["translation_error"])
            self.assertLess(run["rotation_error_deg"], plain["rotation_error_deg"])
            self.assertEqual((run["inliers"], run["status"]), (plain["inliers"], plain["status"]))
            self.assertEqual(run["stages"][-1]["name"], "refine")
            saved = [[float(x) for x in line.split()] for line in (self.folder / "refined.txt").read_text().splitlines()]
            self.assertEqual(saved, run["T_target_source"])
        text = self.run_command("register", source, target, "--voxel", 0.15, "--refine", "plane")
        self.assertIn("refinement    converged after ", text)
        self.assertIn("refined     2 of the 2", self.run_command(
            "register", source, target, "--voxel", 0.15, "--refine", "plane", "--repeat", 2))
        self.assert_error("register", source, target, "--refine", "icp",
                          says="unknown refinement 'icp', expected one of point, plane, gicp")

    def test_aligned_source(self):
        source, target = self.clouds()
        lines = (self.folder / target).read_text().splitlines()
        (self.folder / "back.xyz").write_text("\n".join(lines[:5] + ["nan nan nan"] + lines[5:]) + "\n")
        result = json.loads(self.run_command("register", "back.xyz", source, "--voxel", 0.15, "--json", "-",
                                             "--save-aligned", "aligned.ply"))
        pose = result["runs"][0]["T_target_source"]
        header, data = (self.folder / "aligned.ply").read_bytes().split(b"end_header\n", 1)
        self.assertIn(f"element vertex {len(lines) + 1}".encode(), header)
        rows = [struct.unpack_from("<3d", data, 24 * row) for row in range(len(lines) + 1)]
        self.assertEqual(len(data), 24 * len(rows))
        self.assertTrue(all(math.isnan(x) for x in rows[5] + rows[-1]))
        for row in (0, 4, 6, 1000):
            p = [float(x) for x in lines[row if row < 5 else row - 1].split()]
            for c in range(3):
                self.assertAlmostEqual(rows[row][c], sum(pose[c][k] * p[k] for k in range(3)) + pose[c][3], places=5)
        self.assert_error("register", "pose.txt", "--save-aligned", "a.ply", says="--save-aligned a.ply is of two clouds")

    def test_clouds_decide(self):
        source, target = self.clouds()
        result = json.loads(self.run_command("register", source, target, "--repeat", 2, "--json", "-"))
        for run in result["runs"]:
            found = run["verification"]
            self.assertEqual((run["status"], found["of_correspondences"]), ("success", "success"))
            self.assertGreater(found["pose"]["agreement"], 0.5)
            self.assertLess(found["pose"]["seen_through"], 0.05)
            self.assertLess(found["pose"]["log10_chance"], -2.5)
            self.assertFalse(found["found_by_clouds"])
            self.assertGreaterEqual(found["pose"]["fitted_agreement"], 0.5)
            self.assertLess(found["pose"]["fitted_seen_through"], 0.05)
            self.assertEqual(run["stages"][-1]["name"], "verification")
        self.assertIn("clouds        agree at ", self.run_command("register", source, target))
        alone = json.loads(self.run_command("register", source, target, "--no-verification", "--json", "-"))["runs"][0]
        self.assertNotIn("verification", alone)
        # Noise in a cube has no pose to find.
        draw = random.Random(5)
        for name in ("one", "other"):
            lines = [" ".join(str(draw.uniform(-5, 5)) for _ in range(3)) for _ in range(3000)]
            (self.folder / f"{name}.xyz").write_text("\n".join(lines) + "\n")
        run = json.loads(self.run_command("register", "one.xyz", "other.xyz", "--json", "-", code=1))["runs"][0]
        self.assertEqual((run["T_target_source"], run["attempts"]), (None, 4))

    def test_match_writes_what_register_reads(self):
        source, target = self.clouds()
        text = self.run_command("match", source, target, "--voxel", 0.15, "--out", "pair")
        self.assertIn("correspondences in pair/correspondences.txt", text)
        self.run_command("register", source, target, "--voxel", 0.15, "--save-correspondences", "saved.txt")
        saved = (self.folder / "saved.txt").read_text()
        self.assertEqual(saved, (self.folder / "pair/correspondences.txt").read_text())
        result = json.loads(self.run_command("register", "saved.txt", "--noise-bound", 0.3, "--json", "-"))
        self.assertEqual(result["correspondences"], saved.count("\n") - 1)
        self.assertEqual(result["runs"][0]["status"], "success")

    def test_choices(self):
        source, target = self.clouds()
        few = json.loads(self.run_command("register", source, target, "--keypoints", "random:500", "--matches",
                                          "nearest:1", "--voxel", 0.2, "--json", "-"))
        self.assertEqual(few["clouds"]["source"]["descriptors"], 500)
        self.assertEqual(few["correspondences"], 500)
        iss = json.loads(self.run_command("register", source, target, "--keypoints", "iss", "--voxel", 0.15, "--json",
                                          "-", "--truth", "pose.txt"))
        self.assertEqual([stage["name"] for stage in iss["clouds"]["stages"]],
                         ["voxel_grid", "normals", "iss", "fpfh", "matches"])
        self.assertEqual(iss["clouds"]["keypoints"], "iss")
        self.assertLess(iss["clouds"]["source"]["descriptors"], iss["clouds"]["source"]["voxels"] / 10)
        self.assertLess(iss["runs"][0]["rotation_error_deg"], 2)
        text = self.run_command("match", source, target, "--keypoints", "iss:90", "--voxel", 0.15, "--out", "few")
        self.assertEqual(text.count(" 90 described"), 2)

    def test_errors(self):
        source, target = self.clouds()
        (self.folder / "empty.xyz").write_text("")
        (self.folder / "cut.ply").write_bytes((self.folder / source).read_bytes()[:-1])
        self.assert_error("register", source, "empty.xyz", says="empty.xyz: holds no points")
        self.assert_error("register", "cut.ply", target, says="cut.ply: ends before its 20000 points do")
        self.assert_error("register", source, target, "--voxel", 500, says="voxel is 500")
        self.assert_error("register", source, target, "--voxel", 1e-9, says="voxel is 1e-09")
        self.assert_error("register", source, target, "--keypoints", "some", says="--keypoints: expected all, random:COUNT, farthest:COUNT, iss or iss:COUNT, got 'some'")
        self.assert_error("match", source, target, "--matches", "mutual:9", says="--matches: expected mutual:K")
        self.assert_error("register", source, target, "--estimate-scale", says="--estimate-scale")
        self.assert_error("register", "pose.txt", "--no-verification", says="--no-verification is of two clouds")
        self.assert_error("register", "pose.txt", "--voxel", 1, says="--voxel 1 is of two clouds")
        self.assert_error("register", "-", "-", says="the standard input holds one cloud")
        self.assert_error("register", source, says="source.ply: not a file of correspondences; a cloud needs the TARGET")
        self.assert_error("register", "absent.ply", says="absent.ply: cannot read")
        self.assert_error("match", source, "absent.ply", "--out", "pair", says="absent.ply: cannot read")
        self.assertFalse((self.folder / "pair").exists())


if __name__ == "__main__":
    unittest.main()
