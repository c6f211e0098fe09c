#!/usr/bin/env python3
"""Holds consimd's way from two scans to a pose beside those of Open3D, KISS-Matcher and PCL: times, true matches, poses found.

front_ends.py CONSIMD PAIRS [--pcl PROGRAM] [--rounds N] [--cpu K]

CONSIMD: the command. PAIRS: a JSON list of {"name", "source", "target", "voxel", "T_target_source"}, whose files lie beside
it (PLY, PCD, KITTI's .bin); where the pose is null the scans are of different places, and any pose is wrong. made_up_scans.py
makes such lists. All run on one core, one after another in each round, so that ratios come from like moments;
prints tables in Markdown. Needs a Python with the peers: pip install open3d kiss-matcher numpy. PROGRAM is the target
consimd_pcl_front_end, which the build has where PCL is installed (Debian: libpcl-dev); without it PCL is left out.

All take the same voxels, normals of two and descriptors of five voxels, Open3D and PCL the same number of random points.
Neither reading files is timed nor filling a peer's type of cloud. Matches of the descriptors of Open3D and PCL are chosen
as consimd chooses them, mutual best three, to hold descriptor beside descriptor; their time of matching is that of their
own mutual nearest ones.
"""

import argparse
import importlib.metadata
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

KEYPOINTS = 5000
BEST = 3
MAX_ROTATION_DEG = 5.0
MAX_TRANSLATION_M = 0.6
TRUE_VOXELS = 2.0  # a match is true within so many voxels, the usual bound


def errors(pose, truth):
    """Rotation error in degrees, translation error."""
    turn = pose[:3, :3].T @ truth[:3, :3]
    cosine = np.clip((np.trace(turn) - 1) / 2, -1, 1)
    return np.degrees(np.arccos(cosine)), float(np.linalg.norm(pose[:3, 3] - truth[:3, 3]))


def outcome(pose, truth):
    """Right, wrong, or none where a front end says that it has found no pose."""
    if pose is None:
        return "none"
    if truth is None:
        return "wrong"
    rotation, translation = errors(pose, truth)
    return "right" if rotation <= MAX_ROTATION_DEG and translation <= MAX_TRANSLATION_M else "wrong"


def true_matches(source, target, pair):
    if pair["truth"] is None:
        return 0
    moved = source @ pair["truth"][:3, :3].T + pair["truth"][:3, 3]
    return int((np.linalg.norm(moved - target, axis=1) <= TRUE_VOXELS * pair["voxel"]).sum())


def read_points(path):
    if path.suffix == ".bin":
        points = np.fromfile(path, np.float32).reshape(-1, 4)[:, :3].astype(float)
    else:
        points = np.asarray(o3d.io.read_point_cloud(str(path)).points)
    return points[np.isfinite(points).all(axis=1)]


def mutual_best(source, target):
    """Pairs of rows among each other's BEST nearest descriptors."""

    def nearest(a, b):
        rows = []
        for part in np.array_split(a, max(1, len(a) // 500)):
            squares = (part**2).sum(1)[:, None] - 2 * part @ b.T + (b**2).sum(1)
            rows.append(np.argpartition(squares, BEST, axis=1)[:, :BEST])
        return np.concatenate(rows)

    forth, back = nearest(source, target), nearest(target, source)
    pairs = [(i, j) for i in range(len(source)) for j in forth[i] if i in back[j]]
    return np.array(pairs, dtype=int).reshape(-1, 2)


def run_consimd(pair, arguments, seed):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "matches.txt"
        command = [arguments.consimd, "register", pair["source"], pair["target"], "--voxel", pair["voxel"], "--seed", seed,
                   "--keypoints", f"random:{KEYPOINTS}", "--save-correspondences", file, "--json", "-"]  # fmt: skip
        done = subprocess.run([*map(str, command), *arguments.options], capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"front_ends: {done.stderr.strip()}")
        rows = np.loadtxt(file).reshape(-1, 6)
    said = json.loads(done.stdout)
    run = said["runs"][0]
    times = {stage["name"]: stage["seconds"] for stage in said["clouds"]["stages"]}
    times["registration"] = run["seconds"]
    pose = np.array(run["T_target_source"]) if run["status"] in ("success", "ambiguous") else None
    return times, {"consimd": pose}, (len(rows), true_matches(rows[:, :3], rows[:, 3:], pair))


def run_open3d(pair, _, seed):
    times = {}
    registration = o3d.pipelines.registration

    def timed(name, work):
        start = time.perf_counter()
        result = work()
        times[name] = times.get(name, 0) + time.perf_counter() - start
        return result

    draw = np.random.default_rng(seed)
    o3d.utility.random.seed(seed)
    voxel, sides = pair["voxel"], []
    for points in pair["points"]:
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
        cloud = timed("voxel_grid", lambda c=cloud: c.voxel_down_sample(voxel))
        timed("normals", lambda c=cloud: c.estimate_normals(o3d.geometry.KDTreeSearchParamRadius(2 * voxel)))
        timed("normals", lambda c=cloud: c.orient_normals_towards_camera_location())
        rows = np.sort(draw.permutation(len(cloud.points))[:KEYPOINTS])
        search = o3d.geometry.KDTreeSearchParamRadius(5 * voxel)
        features = timed("fpfh", lambda c=cloud, s=search, r=rows: registration.compute_fpfh_feature(c, s, r))
        sides.append((cloud.select_by_index(rows), features))
    (source, of_source), (target, of_target) = sides
    timed("matches", lambda: registration.correspondences_from_features(of_source, of_target, True))
    bound = TRUE_VOXELS * voxel
    checks = [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
              registration.CorrespondenceCheckerBasedOnDistance(bound)]  # fmt: skip
    estimate = registration.TransformationEstimationPointToPoint(False)
    criteria = registration.RANSACConvergenceCriteria(50000, 0.999)
    ransac = timed("registration", lambda: registration.registration_ransac_based_on_feature_matching(
        source, target, of_source, of_target, True, bound, estimate, 3, checks, criteria))  # fmt: skip
    option = registration.FastGlobalRegistrationOption(maximum_correspondence_distance=bound)
    fast = registration.registration_fgr_based_on_feature_matching(source, target, of_source, of_target, option)
    pairs = mutual_best(np.asarray(of_source.data).T, np.asarray(of_target.data).T)
    p, q = np.asarray(source.points)[pairs[:, 0]], np.asarray(target.points)[pairs[:, 1]]
    poses = {"Open3D RANSAC 50k": ransac.transformation, "Open3D FGR": fast.transformation}
    return times, poses, (len(pairs), true_matches(p, q, pair))


def run_kiss(pair, _, __):
    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(pair["voxel"]))
    solution = matcher.estimate(*pair["float_points"])
    times = {
        "voxel_grid": matcher.get_processing_time(),
        "normals and fpfh": matcher.get_extraction_time(),
        "matches": matcher.get_matching_time(),
        "registration": matcher.get_rejection_time() + matcher.get_solver_time(),
    }
    pose = None
    if solution.valid:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = solution.rotation, np.ravel(solution.translation)
    p, q = (np.array(side, dtype=float).reshape(-1, 3) for side in matcher.get_keypoints_from_initial_matching())
    return times, {"KISS-Matcher": pose}, (len(p), true_matches(p, q, pair))


def run_pcl(pair, arguments, seed):
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / side for side in ("source", "target")]
        for file, points in zip(files, pair["float_points"]):
            points.tofile(file)
        out = pathlib.Path(folder) / "out"
        command = [arguments.pcl, *files, pair["voxel"], KEYPOINTS, seed, out]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"front_ends: {done.stderr.strip()}")
        said = json.loads(done.stdout)
        arguments.pcl_version = said["version"]
        sides = [np.fromfile(f"{out}.{side}", np.float32).reshape(-1, 36).astype(float) for side in ("source", "target")]
    pairs = mutual_best(*[side[:, 3:] for side in sides])
    p, q = (side[pairs[:, k], :3] for k, side in enumerate(sides))
    poses = {"PCL RANSAC 50k": np.array(said["T_target_source"]).reshape(4, 4)}
    return said["seconds"], poses, (len(pairs), true_matches(p, q, pair))


PEERS = {"consimd": run_consimd, "Open3D": run_open3d, "KISS-Matcher": run_kiss, "PCL": run_pcl}


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def table_of_times(times):
    """Milliseconds a pair, and ratios to consimd's: medians over all rounds and pairs of like moments."""
    names = []
    for peer in PEERS:
        names += [name for name in times[peer][0] if name not in names]
    names.sort(key=lambda name: name == "registration")
    print("\nMilliseconds for both scans, median over rounds and pairs; last: how often consimd's time, round by round\n")
    row("front end", *names, "all", "ratio")
    row("---", *["--:"] * (len(names) + 2))
    own = [sum(stages.values()) for stages in times["consimd"]]
    for peer in PEERS:
        cells = []
        for name in names:
            spent = [stages[name] for stages in times[peer] if name in stages]
            cells.append(f"{1e3 * statistics.median(spent):.1f}" if spent else "")
        whole = [sum(stages.values()) for stages in times[peer]]
        ratio = statistics.median(theirs / ours for theirs, ours in zip(whole, own))
        row(peer, *cells, f"{1e3 * statistics.median(whole):.1f}", f"{ratio:.1f}")


def table_of_pairs(pairs, times):
    print("\nMilliseconds from the points in memory to the correspondences, and to the pose, least of all rounds\n")
    row("pair", *PEERS)
    row("---", *["--:"] * len(PEERS))
    for k, name in enumerate(pairs):
        cells = []
        for peer in PEERS:
            rounds = times[peer][k :: len(pairs)]
            poses = [sum(stages.values()) for stages in rounds]
            matches = [pose - stages["registration"] for pose, stages in zip(poses, rounds)]
            cells.append(f"{1e3 * min(matches):.1f}, {1e3 * min(poses):.1f}")
        row(name, *cells)


def table_of_matches(pairs, matches, found):
    print("\nTrue matches of all, mean over rounds\n")
    row("pair", *PEERS)
    row("---", *["--:"] * len(PEERS))
    for name in pairs:
        means = [[statistics.mean(m[k] for m in matches[peer][name]) for k in (1, 0)] for peer in PEERS]
        row(name, *[f"{true:.0f} of {all_of_them:.0f}" for true, all_of_them in means])
    solvers = list(found)
    print(f"\nPoses within {MAX_ROTATION_DEG} degrees and {MAX_TRANSLATION_M} m, and wrong ones that are called a pose as well\n")
    row("pair", *solvers)
    row("---", *["--:"] * len(solvers))

    def counts(outcomes):
        return f"{outcomes.count('right')}, {outcomes.count('wrong')}"

    for name in pairs:
        row(name, *[counts(found[solver][name]) for solver in solvers])
    row(f"all of {sum(map(len, found['consimd'].values()))}", *[counts(sum(found[solver].values(), [])) for solver in solvers])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("consimd", help="the command consimd")
    parser.add_argument("pairs", type=pathlib.Path, help="JSON list of pairs of scans")
    parser.add_argument("--pcl", type=pathlib.Path, help="the program consimd_pcl_front_end; without it PCL is left out")
    parser.add_argument("--rounds", type=int, default=5, help="how often each runs on each pair; the round is the seed")
    parser.add_argument("--cpu", type=int, default=0, help="the core that all of them run on")
    parser.add_argument("--options", nargs="*", default=["--no-verification"], help="further ones for consimd register")
    arguments = parser.parse_args()
    if arguments.pcl is None:
        del PEERS["PCL"]
    elif not arguments.pcl.is_file():
        parser.error(f"--pcl: {arguments.pcl} is no file; the build target consimd_pcl_front_end makes it")
    os.sched_setaffinity(0, {arguments.cpu})
    os.environ.update(OMP_NUM_THREADS="1", TBB_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    global kiss_matcher, np, o3d
    import kiss_matcher
    import numpy as np
    import open3d as o3d

    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    pairs = json.loads(arguments.pairs.read_text())
    for pair in pairs:
        for side in ("source", "target"):
            pair[side] = arguments.pairs.parent / pair[side]
        pair["truth"] = None if pair["T_target_source"] is None else np.array(pair["T_target_source"])
        pair["points"] = [read_points(pair[side]) for side in ("source", "target")]
        pair["float_points"] = [points.astype(np.float32) for points in pair["points"]]
    times = {peer: [] for peer in PEERS}
    matches = {peer: {pair["name"]: [] for pair in pairs} for peer in PEERS}
    found = {}
    for seed in range(1, arguments.rounds + 1):
        for pair in pairs:
            for peer, run in PEERS.items():
                spent, poses, matched = run(pair, arguments, seed)
                times[peer].append(spent)
                matches[peer][pair["name"]].append(matched)
                for solver, pose in poses.items():
                    outcomes = found.setdefault(solver, {p["name"]: [] for p in pairs})
                    outcomes[pair["name"]].append(outcome(pose, pair["truth"]))
            print(f"round {seed}, {pair['name']}", file=sys.stderr)
    info = json.loads(subprocess.run([arguments.consimd, "info", "--json"], capture_output=True, text=True, check=True).stdout)
    versions = ", ".join(f"{name} {info[name]}" for name in ("version", "isa", "compiler", "flags") if name in info)
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    peers = f"Open3D {o3d.__version__}; KISS-Matcher {importlib.metadata.version('kiss-matcher')}"
    if arguments.pcl:
        peers += f"; PCL {arguments.pcl_version}"
    print(f"{model or platform.machine()}, one core; consimd {versions}; {peers}; {arguments.rounds} rounds")
    table_of_times(times)
    table_of_pairs([pair["name"] for pair in pairs], times)
    table_of_matches([pair["name"] for pair in pairs], matches, found)


if __name__ == "__main__":
    main()
