#!/usr/bin/env python3
"""Draws view.png: the page of `consimd register --view`, as Chromium shows it, for two scans of a street that is made up.

Usage: view.py CONSIMD [PNG]      CONSIMD: the command; PNG: view.png beside this script unless given
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests/cli"))
from browser import take_screenshot  # noqa: E402


def street(rng):
    """Boxes (lowest and highest corner) and balls (centre and radius): houses, cars, trunks, crowns."""
    boxes, balls = [], []
    for side in (-1, 1):
        x = -70.0
        while x < 70:
            width, depth, height = rng.uniform(8, 16), rng.uniform(6, 10), rng.uniform(5, 12)
            front = side * rng.uniform(9, 11)
            boxes.append(((x, min(front, front + side * depth), 0), (x + width, max(front, front + side * depth), height)))
            if rng.random() < 0.8:
                middle = x + rng.uniform(2, width - 2)
                boxes.append(((middle, min(front, front - side * 1.2), 0), (middle + 1.6, max(front, front - side * 1.2), 2.6)))
            x += width + rng.choice([0, 0, 3.5])
        for x in rng.uniform(-60, 60, 9):
            y = side * rng.uniform(4.6, 5.2)
            boxes.append(((x, y - 0.9, 0.15), (x + 4.2, y + 0.9, 0.9)))
            boxes.append(((x + 1, y - 0.8, 0.9), (x + 3.4, y + 0.8, 1.5)))
        for x in rng.uniform(-60, 60, 6):
            y = side * rng.uniform(7.2, 7.8)
            boxes.append(((x - 0.2, y - 0.2, 0), (x + 0.2, y + 0.2, 2.6)))
            balls.append(((x, y, 4.2), rng.uniform(1.3, 2.1)))
    return boxes, balls


def scan(boxes, balls, at, yaw, rng):
    """Points of a spinning sensor of 64 rings at `at`, in its own frame."""
    azimuth, elevation = np.meshgrid(np.linspace(-np.pi, np.pi, 1500, endpoint=False), np.radians(np.linspace(-24, 8, 64)))
    rays = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], -1).reshape(-1, 3)
    nearest = np.where(rays[:, 2] < 0, -at[2] / np.minimum(rays[:, 2], -1e-9), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for low, high in boxes:
            a, b = (np.array(low) - at) / rays, (np.array(high) - at) / rays
            enters, leaves = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
            nearest = np.where((enters < leaves) & (enters > 0), np.minimum(nearest, enters), nearest)
    for centre, radius in balls:
        towards = np.array(centre) - at
        along = rays @ towards
        inside = radius**2 - (towards @ towards - along**2)
        distance = along - np.sqrt(np.maximum(inside, 0)) + rng.normal(0, 0.25, len(rays))  # leaves
        nearest = np.where((inside > 0) & (distance > 0), np.minimum(nearest, distance), nearest)
    seen = nearest < 60
    points = rays[seen] * (nearest[seen] + rng.normal(0, 0.015, seen.sum()))[:, None]
    turn = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    return (points @ turn.T).astype(np.float32)


def main():
    command, picture = sys.argv[1], pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else HERE / "view.png")
    rng = np.random.default_rng(5)
    boxes, balls = street(rng)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        np.save(folder / "source.npy", scan(boxes, balls, np.array([4.0, 1.0, 1.8]), 0.5, rng))
        np.save(folder / "target.npy", scan(boxes, balls, np.array([-4.0, -0.5, 1.8]), 0.0, rng))
        arguments = [pathlib.Path(command).resolve(), "register", "source.npy", "target.npy", "--voxel", "0.3", "--view", "view.html"]
        print(subprocess.run(arguments, cwd=folder, check=True, capture_output=True, text=True).stdout)
        shots = [folder / f"{placement}.png" for placement in ("before", "after")]
        for shot in shots:
            take_screenshot(folder / "view.html", shot, f"#{shot.stem}", 1000, 640)
        both = np.concatenate([np.asarray(Image.open(shot).convert("RGB")) for shot in shots])
    # Few colours: a tenth of the bytes, and no difference to the eye.
    Image.fromarray(both).quantize(48, dither=Image.Dither.NONE).save(picture, optimize=True)


if __name__ == "__main__":
    main()
