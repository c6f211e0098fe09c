"""The Python that draws figures in tests."""

import subprocess
import sys


def has_matplotlib(python):
    try:
        return subprocess.run([python, "-I", "-c", "import matplotlib"], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


PLOTTER = next(filter(has_matplotlib, (sys.executable, "/usr/bin/python3")), None)
