#!/usr/bin/env python3
"""Holds the includes of the C++ sources against three tables: which layers a layer may use, which rooms of the solvers a
room may use, and which sources may call POSIX.

check_includes.py [--graph]: exit status 1 and a line per fault where a source includes what its layer or room may not, or
where the rooms include one another in a circle. --graph prints the rooms in layers, each with those that it includes.
"""

import argparse
import re
import sys
from pathlib import Path

# A layer is a folder of the project. What it may include of others: <consimd/LAYER/...>, "LAYER/...".
LAYERS = {
    "text": "",
    "kernels": "",
    "poses": "kernels",
    "solvers": "poses kernels text",
    "features": "solvers poses kernels text",
    "synth": "poses kernels text",
    "studies": "features solvers synth poses kernels text",
    "bench": "studies features solvers synth poses kernels text",
    "cli": "studies features solvers synth poses kernels text",
    "python": "studies features solvers synth poses kernels",
    "examples": "studies features solvers synth poses kernels",
    "fuzz": "studies features solvers synth poses kernels",
}

# A room is a folder of solvers/src. A public header belongs to the room that has the source of its name.
SHARED = "verdict support sampling call bits"
ROOMS = {
    "bits": "",
    "call": "",
    "sampling": "",
    "cliques": "bits call",
    "support": "sampling call bits",
    "verdict": "support sampling call bits",
    "search": SHARED,
    "noise_bound": "scale search " + SHARED,
    "assumed_inliers": SHARED,
    "advice": "assumed_inliers noise_bound pcr99 call",
    "scale": "search " + SHARED,
    "ransac": "scale search " + SHARED,
    "tcf": "ransac scale search " + SHARED,
    "sc2_pcr": "scale search " + SHARED,
    "turboreg": "scale search " + SHARED,
    "mac": "cliques scale search " + SHARED,
    "pcr99": "scale search " + SHARED,
    "teaser": "cliques scale search " + SHARED,
    "registry": "tcf ransac sc2_pcr turboreg pcr99 teaser mac noise_bound scale search " + SHARED,
}
# The room of a public header without a source.
HEADER_ROOMS = {"consensus_set": "tcf", "pose_covariance": "call", "pose_ranking": "support"}

# The sources of libraries, command and Python module that call the operating system, each for one purpose. The others are
# standard C++. Tests and fuzz targets may.
POSIX = {
    "synth/src/pending_file.cpp": "files that appear whole or not at all",
    "studies/src/files/folder_lock.cpp": "one process in a study's folder",
    "studies/src/figures/figures.cpp": "the process that draws",
    "studies/src/outside/child_process.cpp": "outside solvers' programs",
    "studies/src/provenance/machine.cpp": "the system's name",
    "cli/interruption.cpp": "signals",
    "cli/standard_streams.cpp": "descriptors and terminals",
    "python/src/interruptible_call.cpp": "forked interpreters",
}
POSIX_HEADER = re.compile(r"(sys|net|arpa|netinet)/|(unistd|fcntl|signal|spawn|pthread|poll|dirent|dlfcn|termios|pwd|sched|semaphore)\.h$")

INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]')


def sources(folder):
    return sorted(path for path in folder.rglob("*") if path.suffix in (".hpp", ".cpp"))


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if match := INCLUDE.match(line):
            yield number, match[1]


def fault(root, path, number, kind, home, included, allowed):
    may = allowed.replace(" ", ", ") or "none"
    return f"{path.relative_to(root)}:{number}: includes {included}; {kind} {home} may use: {may}"


def layer_faults(root):
    for layer, allowed in LAYERS.items():
        for path in sources(root / layer):
            for number, included in includes(path):
                used = included.removeprefix("consimd/").split("/")[0]
                # A library's own private folders may have a layer's name.
                private = any((root / layer / folder / included).exists() for folder in ("src", "."))
                if used in LAYERS and used != layer and not private and used not in allowed.split():
                    yield fault(root, path, number, "layer", layer, included, allowed)


def posix_faults(root):
    for layer in LAYERS.keys() - {"fuzz"}:
        for path in sources(root / layer):
            if path.relative_to(root).as_posix() in POSIX:
                continue
            for number, included in includes(path):
                if POSIX_HEADER.match(included):
                    yield f"{path.relative_to(root)}:{number}: includes {included}; POSIX is called in {', '.join(POSIX)} alone"


class Rooms:
    def __init__(self, root):
        self.root = root
        self.faults = []
        self.edges = {room: set() for room in ROOMS}
        src, headers = root / "solvers/src", root / "solvers/include/consimd/solvers"
        self.header_rooms = dict(HEADER_ROOMS)
        for path in sources(src):
            room = path.relative_to(src).parts[0]
            if room not in ROOMS:
                self.faults.append(f"{path.relative_to(root)}: solvers/src/{room} is not among the rooms of {Path(__file__).name}")
            elif path.suffix == ".cpp" and (headers / path.with_suffix(".hpp").name).exists():
                self.header_rooms[path.stem] = room
        for path in sources(headers):
            if path.stem in self.header_rooms:
                self.read(path, self.header_rooms[path.stem])
            else:
                self.faults.append(f"{path.relative_to(root)}: no room has a source of this name")
        for path in sources(src):
            if (room := path.relative_to(src).parts[0]) in ROOMS:
                self.read(path, room)
        if circle := self.circle():
            self.faults.append("the rooms include one another in a circle: " + " -> ".join(circle))

    def read(self, path, room):
        for number, included in includes(path):
            folder, *rest = included.removeprefix("consimd/").split("/")
            used = self.header_rooms.get(Path(included).stem) if folder == "solvers" else folder if rest else None
            if used not in ROOMS or used == room:
                continue
            self.edges[room].add(used)
            if used not in ROOMS[room].split():
                self.faults.append(fault(self.root, path, number, "room", room, included, ROOMS[room]))

    def circle(self):
        """Rooms that include one another, the first one again at the end; None without."""
        done = set()

        def follow(way):
            for used in sorted(self.edges[way[-1]] - done):
                if used in way:
                    return [*way[way.index(used) :], used]
                if found := follow([*way, used]):
                    return found
            done.add(way[-1])
            return None

        for room in ROOMS:
            if room not in done and (found := follow([room])):
                return found
        return None

    def graph(self):
        """A line per room, those that include nothing first, each with what it includes and no room between does."""
        reach = {}

        def reachable(room):
            if room not in reach:
                reach[room] = set().union(*({used} | reachable(used) for used in self.edges[room]))
            return reach[room]

        level = {}

        def height(room):
            if room not in level:
                level[room] = 1 + max((height(used) for used in self.edges[room]), default=-1)
            return level[room]

        for room in sorted(ROOMS, key=lambda room: (height(room), room)):
            direct = self.edges[room] - set().union(*(reachable(used) for used in self.edges[room]))
            yield f"{height(room)}  {room:12}" + (f" -> {', '.join(sorted(direct))}" if direct else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--graph", action="store_true", help="print which rooms include which, without what follows from the rest")
    arguments = parser.parse_args()
    root = Path(__file__).resolve().parent.parent
    rooms = Rooms(root)
    faults = [*layer_faults(root), *posix_faults(root), *rooms.faults]
    for line in faults:
        print(line, file=sys.stderr)
    if arguments.graph and not rooms.circle():
        print("\n".join(rooms.graph()))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
