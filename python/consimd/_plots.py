"""Figures that need matplotlib: those of a noise study, and drawings as PNG."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_SCRIPTS = Path(__file__).resolve().parent / "figures"


def plot_sweep(cells: NDArray[np.void] | None, folder: str | os.PathLike[str]) -> list[Path]:
    """Draws recall and errors over the noise level, as the command `consimd sweep` does; the files, SVG and PNG.

    cells: rows as `SweepResult.cells` has them, or a structured array of your own with the columns that
        docs/noise_study.md names. They are written to `folder` / cells.csv. None: that file is there already.
    folder: made if missing.

    Needs matplotlib. RuntimeError with what the script said if it cannot draw.
    """
    folder = Path(folder)
    if cells is not None:
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "cells.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(cells.dtype.names or ())
            writer.writerows(cells.tolist())
    run_script("plot_sweep.py", folder, f"figures of {folder}")
    return [folder / f"{name}.{end}" for name in ("recall", "errors") for end in ("svg", "png")]


def run_script(script: str, folder: Path, what: str) -> None:
    """Draws what a script makes of the files in a folder. RuntimeError with what it said if it cannot."""
    done = subprocess.run(
        [sys.executable, "-B", str(_SCRIPTS / script), str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise RuntimeError(f"{what} not drawn: {said[-1]}")
