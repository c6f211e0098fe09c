#!/usr/bin/env python3
"""Makes up pairs of scans, of one place or of different ones, for front_ends.py.

made_up_scans.py FOLDER [--kinds KIND...] [--count N] [--seed S]

Streets, open places and forests as a lidar of 48 rings sees them from two points 5 to 28 m apart, and furnished rooms as a
scanner on a tripod does. Writes into FOLDER the scans as KITTI's .bin (float32 x y z reflectance, metres, sensor frame),
pairs.json of two scans of one place each, and different_places.json of the first scans of two places each, for which there is
no pose: whoever names one is wrong. Scans of a seed are the same however many are made. Needs numpy.
"""

import argparse
import dataclasses
import json
import pathlib

import numpy as np

NEVER = np.inf
CLEAR = 0.5  # metres about a viewpoint without a shape


def turned_about_z(yaw):
    return np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])


# Shapes: distances from `origin` along unit `rays` (N x 3) to where these meet the surface, NEVER where they do not; and
# whether a point is within them, or nearly so.


@dataclasses.dataclass
class Ground:
    def distances(self, origin, rays, _):
        return np.where(rays[:, 2] < 0, -origin[2] / rays[:, 2], NEVER)

    def holds(self, _):
        return False


@dataclasses.dataclass
class Box:
    centre: np.ndarray
    size: np.ndarray
    yaw: float = 0.0
    seen_from_within: bool = False

    def distances(self, origin, rays, _):
        to_box = turned_about_z(-self.yaw)
        start, rays, half = to_box @ (origin - self.centre), rays @ to_box.T, np.asarray(self.size) / 2
        low, high = (-half - start) / rays, (half - start) / rays
        enter, leave = np.minimum(low, high).max(1), np.maximum(low, high).min(1)
        if self.seen_from_within:
            return np.where(leave > 0, leave, NEVER)
        return np.where((enter < leave) & (enter > 0), enter, NEVER)

    def holds(self, point):
        off = turned_about_z(-self.yaw) @ (point - self.centre)
        return not self.seen_from_within and bool((np.abs(off) < np.asarray(self.size) / 2 + CLEAR).all())


@dataclasses.dataclass
class Trunk:
    place: np.ndarray  # x, y
    radius: float
    height: float

    def distances(self, origin, rays, _):
        off = origin[:2] - self.place
        a, b, c = (rays[:, :2] ** 2).sum(1), rays[:, :2] @ off, off @ off - self.radius**2
        t = (-b - np.sqrt(b * b - a * c)) / a
        z = origin[2] + t * rays[:, 2]
        return np.where((t > 0) & (z > 0) & (z < self.height), t, NEVER)

    def holds(self, point):
        return bool(np.linalg.norm(point[:2] - self.place) < self.radius + CLEAR)


@dataclasses.dataclass
class Crown:
    """Leaves: a ray ends somewhere in the outer half of the radius."""

    centre: np.ndarray
    radius: float

    def distances(self, origin, rays, rng):
        off = origin - self.centre
        b, c = rays @ off, off @ off - self.radius**2
        t = -b - np.sqrt(b * b - c)
        return np.where(t > 0, t + rng.uniform(0, self.radius / 2, len(rays)), NEVER)

    def holds(self, point):
        return bool(np.linalg.norm(point - self.centre) < self.radius + CLEAR)


def tree(place, rng, crowns):
    height = rng.uniform(2, 4)
    return [Trunk(place, rng.uniform(0.1, 0.3), height), Crown(np.array([*place, height + 1.5]), rng.uniform(*crowns))]


def car(place, yaw, rng):
    length = rng.uniform(3.8, 5)
    cabin = [length * 0.55, 1.6, 1 + 0.9 * rng.random()]
    return [Box(np.array([*place, 0.75]), [length, 1.8, 1.5], yaw), Box(np.array([*place, 1.0]), cabin, yaw)]


def street(rng):
    """Along x: houses, lamps at equal distances, parked cars and trees on both sides; a crossing in three of ten."""
    shapes, crosses = [Ground()], rng.random() < 0.3
    for side in (-1, 1):
        x = -110.0
        while x < 110:
            width, front, depth, height = rng.uniform([6, 7, 6, 4], [22, 14, 14, 15])
            if rng.random() < 0.85 and not (crosses and abs(x + width / 2) < 9):
                centre = np.array([x + width / 2, side * (front + depth / 2), height / 2])
                shapes.append(Box(centre, [width, depth, height], rng.normal(0, 0.02)))
            if rng.random() < 0.5:
                porch = rng.uniform([1, 0.8, 1], [3, 0.8, 3])
                shapes.append(Box(np.array([x + width * rng.random(), side * (front - 0.4), rng.uniform(1, 3)]), porch))
            x += width + (rng.uniform(1, 9) if rng.random() < 0.6 else 0)
        for x in np.cumsum(rng.uniform(5.5, 25, 40)) - 110:
            shapes += car([x, side * rng.uniform(3.6, 4.4)], rng.normal(0, 0.05), rng)
        for x in np.arange(-110, 110, rng.uniform(18, 32)):
            place = np.array([x + rng.normal(0, 2), side * rng.uniform(5, 6)])
            shapes.append(Trunk(place, rng.uniform(0.08, 0.15), rng.uniform(5, 9)))
        for x in rng.uniform(-110, 110, rng.integers(2, 14)):
            shapes += tree(np.array([x, side * rng.uniform(5.5, 7)]), rng, (1.3, 3))
    return shapes


def open_place(rng):
    """Scattered buildings, trees and cars."""
    shapes = [Ground()]
    for place in rng.uniform(-70, 70, (rng.integers(8, 22), 2)):
        size = rng.uniform([3, 3, 2.5], [18, 18, 10])
        if np.hypot(*place) > 8:
            shapes.append(Box(np.array([*place, size[2] / 2]), size, rng.uniform(0, np.pi)))
    for place in rng.uniform(-60, 60, (rng.integers(5, 30), 2)):
        shapes += tree(place, rng, (1, 3))
    for place in rng.uniform(-50, 50, (rng.integers(0, 12), 2)):
        shapes += car(place, rng.uniform(0, np.pi), rng)
    return shapes


def forest(rng):
    """Trunks and bushes."""
    shapes = [Ground()]
    for place in rng.uniform(-50, 50, (rng.integers(60, 140), 2)):
        shapes.append(Trunk(place, rng.uniform(0.1, 0.4), rng.uniform(6, 14)))
    for place in rng.uniform(-50, 50, (rng.integers(5, 20), 2)):
        shapes.append(Crown(np.array([*place, rng.uniform(0, 0.5)]), rng.uniform(0.4, 1.5)))
    return shapes


def room(rng):
    """Boxes on the floor, most of them along a wall; the origin is the middle of the room."""
    width, depth, height = inside = rng.uniform([4, 4, 2.4], [9, 9, 3.2])
    shapes = [Box(np.zeros(3), inside, seen_from_within=True)]
    for _ in range(rng.integers(5, 14)):
        long, deep, high = rng.uniform([0.3, 0.3, 0.4], [2, 1, 2])
        side, along, yaw = rng.choice([-1, 1]), rng.uniform(-0.5, 0.5), 0.0
        if rng.random() < 0.4:
            x, y, yaw = rng.uniform(-0.3, 0.3) * width, rng.uniform(-0.3, 0.3) * depth, rng.uniform(0, np.pi)
        elif rng.random() < 0.5:
            x, y = along * (width - long), side * (depth - deep) / 2
        else:
            long, deep = deep, long
            x, y = side * (width - long) / 2, along * (depth - deep)
        shapes.append(Box(np.array([x, y, (high - height) / 2]), [long, deep, high], yaw))
    return shapes


@dataclasses.dataclass
class Scanner:
    elevations: np.ndarray  # degrees
    azimuths: int
    reach: float
    noise: float

    def scan(self, shapes, origin, yaw, rng):
        elevation = np.radians(self.elevations)[:, None]
        azimuth = (2 * np.pi / self.azimuths) * np.arange(self.azimuths) + rng.uniform(0, 0.01)
        rays = np.stack(np.broadcast_arrays(np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                                            np.sin(elevation)), -1).reshape(-1, 3)  # fmt: skip
        nearest = np.full(len(rays), NEVER)
        with np.errstate(invalid="ignore", divide="ignore"):  # a ray that misses has no distance
            for shape in shapes:
                nearest = np.fmin(nearest, shape.distances(origin, rays, rng))
        seen = nearest < self.reach
        points = rays[seen] * (nearest + rng.normal(0, self.noise, len(rays)))[seen, None]
        return (points @ turned_about_z(yaw)).astype(np.float32)


@dataclasses.dataclass
class Kind:
    place: callable  # shapes, of random numbers
    scanner: Scanner
    voxel: float
    distances: tuple  # of the two viewpoints, metres, in turn


LIDAR = Scanner(np.linspace(-24, 3, 48), azimuths=900, reach=80, noise=0.02)
TRIPOD = Scanner(np.linspace(-60, 60, 150), azimuths=300, reach=30, noise=0.006)
KINDS = {
    "street": Kind(street, LIDAR, 0.3, (12, 20, 28)),
    "open": Kind(open_place, LIDAR, 0.3, (12, 20, 28)),
    "forest": Kind(forest, LIDAR, 0.3, (5, 9, 14)),
    "room": Kind(room, TRIPOD, 0.1, ()),
}


def viewpoints(name, shapes, number, rng):
    """Where the two scans of a place are taken from: origins and yaws."""
    if name == "room":
        return rng.uniform(-0.3, 0.3, (2, 3)) * shapes[0].size, rng.uniform(0, 2 * np.pi, 2)
    distance = KINDS[name].distances[number % len(KINDS[name].distances)]
    heading, yaws = rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi, 2)
    aside = 0.0
    if name == "street":  # on the lane, the second one way or the other
        heading, aside = 0.0, rng.uniform(-1.5, 1.5, 2)
        yaws = rng.normal(0, 0.1, 2) + [0, rng.choice([0, np.pi])]
    half = np.array([np.cos(heading), np.sin(heading), 0]) * distance / 2
    origins = np.stack([-half, half])
    origins[:, 1] += aside
    origins[:, 2] = 1.8
    return origins, yaws


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--count", type=int, default=20, help="places of each kind, 2 or more")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    if arguments.count < 2:
        parser.error(f"--count: {arguments.count} places; 2 or more are needed for scans of different ones")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    pairs, different = [], []
    for name in arguments.kinds:
        kind, names = KINDS[name], []
        for number in range(arguments.count):
            rng = np.random.default_rng([arguments.seed, list(KINDS).index(name), number])
            shapes = kind.place(rng)
            origins, yaws = viewpoints(name, shapes, number, rng)
            shapes = [shape for shape in shapes if not any(shape.holds(origin) for origin in origins)]
            files = [f"{name}_{number}_{side}.bin" for side in ("source", "target")]
            for file, origin, yaw in zip(files, origins, yaws):
                points = kind.scanner.scan(shapes, origin, yaw, rng)
                np.hstack([points, np.zeros((len(points), 1), np.float32)]).tofile(arguments.folder / file)
            pose, to_target = np.eye(4), turned_about_z(yaws[1]).T
            pose[:3, :3], pose[:3, 3] = to_target @ turned_about_z(yaws[0]), to_target @ (origins[0] - origins[1])
            pairs.append({"name": f"{name} {number}", "source": files[0], "target": files[1], "voxel": kind.voxel,
                          "T_target_source": pose.tolist()})  # fmt: skip
            names.append(files[0])
        for number, file in enumerate(names):
            other = (number + 1) % len(names)
            different.append({"name": f"{name} {number} and {other}", "source": file, "target": names[other],
                              "voxel": kind.voxel, "T_target_source": None})  # fmt: skip
    (arguments.folder / "pairs.json").write_text(json.dumps(pairs, indent=1))
    (arguments.folder / "different_places.json").write_text(json.dumps(different, indent=1))


if __name__ == "__main__":
    main()
