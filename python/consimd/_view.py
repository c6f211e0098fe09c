"""Registrations to look at."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from consimd import _core
from consimd._core import Correspondences
from consimd._plots import run_script
from consimd._register import Registration

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from consimd.features import CloudMatches


def view(
    file: str | os.PathLike[str],
    registration: Registration,
    source: ArrayLike,
    target: ArrayLike,
    matches: CloudMatches | None = None,
    *,
    names: tuple[str, str] = ("source", "target"),
    missing: float | None = None,
) -> None:
    """Writes a picture of a registration, with a pose or without: points before and after it, inliers and outliers.

    file: to write. Named *.svg or *.png it becomes a drawing, *.html one self-contained page to look around in with a
        browser, as `consimd register --view` and `--picture` write them. PNG needs matplotlib; RuntimeError with what it
        said if it cannot draw. The file appears whole or not at all; OSError or RuntimeError where it cannot be written,
        ValueError of another name.
    registration: what `register` or `register_clouds` returned.
    source, target: the (N, 3) correspondences that were registered; with `matches`, which `register_clouds` returned,
        the (N, 3) and (M, 3) clouds.
    names: of the two, as the picture calls them.
    missing: as in `features.match_clouds`.
    """
    clouds = None
    if matches is None:
        rows = Correspondences(source, target)
    else:
        rows = Correspondences(matches.source_points, matches.target_points)
        clouds = (source, target)
    path = os.fspath(file)
    ending = os.path.splitext(path)[1].lower()
    if ending not in (".html", ".htm", ".svg", ".png"):
        raise ValueError(f"file: expected a name that ends with .html, .htm, .svg or .png, got {path!r}")

    def write(to: str, drawing: bool) -> None:
        _core.write_picture(to, drawing, registration, rows, clouds, missing, *names)

    if ending != ".png":
        write(path, ending == ".svg")
        return
    # Beside the file, so that it can take its name at once.
    with tempfile.TemporaryDirectory(prefix=".consimd-", dir=os.path.dirname(path) or ".") as folder:
        write(os.path.join(folder, "picture.svg"), True)
        run_script("plot_picture.py", Path(folder), path)
        os.replace(os.path.join(folder, "picture.png"), path)
