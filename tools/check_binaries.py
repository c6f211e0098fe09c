#!/usr/bin/env python3
"""Fails where a binary may load a library from the current folder, lacks what makes a fault hard to exploit, or calls
functions that round in their own way from one C library, and from one processor, to another.

Usage: check_binaries.py [--hardened] [--reproducible] FILE|FOLDER...

Looks at every program and shared library there, with readelf. An entry of its RPATH or RUNPATH must be an absolute path or
begin with $ORIGIN: an empty or relative one is the current folder of whoever runs it. With --hardened it must also have
full RELRO and a stack protector, and programs must be position-independent. With --reproducible it must not import the
C library's logarithms, powers, angles and their like, which consimd/kernels/elementary_functions.hpp replaces.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

ELF_MAGIC = b"\x7fELF"
PROGRAM, SHARED = 2, 3  # e_type
# Of the C library, with f and l for the other types. What IEEE 754 rounds in one way (sqrt, floor, ...) is not among them.
INEXACT = re.compile(
    r"\bUND (a?(?:sin|cos|tan)h?|atan2|sincos|exp(?:2|10|m1)?|log(?:2|10|1p)?|pow|cbrt|hypot|erfc?|[lt]?gamma|j[01n]|y[01n])"
    r"([fl]?)(?:@|$|\s)", re.MULTILINE)  # fmt: skip


def kind(path):
    """PROGRAM (at a fixed address) or SHARED (a library, or a program at any address), None for other files."""
    with open(path, "rb") as file:
        head = file.read(18)
    if len(head) < 18 or not head.startswith(ELF_MAGIC):
        return None
    of = int.from_bytes(head[16:18], "little" if head[5] == 1 else "big")
    return of if of in (PROGRAM, SHARED) else None


def binaries(paths):
    for path in paths:
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and not file.is_symlink() and kind(file):
                yield file


def readelf(path):
    run = subprocess.run(["readelf", "-dlW", "--dyn-syms", path], capture_output=True, text=True, check=True)
    return run.stdout


def faults(path, hardened, reproducible):
    text = readelf(path)
    for name, entries in re.findall(r"\((RPATH|RUNPATH)\).*\[(.*)\]", text):
        for entry in entries.split(":"):
            if not entry.startswith(("/", "$ORIGIN")):
                yield f"{name} {entries} has the entry '{entry}', which is or lies in the current folder"
    if reproducible:
        for name in sorted({"".join(found) for found in INEXACT.findall(text)}):
            yield f"calls {name} of the C library, whose results differ between processors"
    if not hardened:
        return
    if not re.search(r"GNU_RELRO", text) or not re.search(r"\(FLAGS\).*BIND_NOW|\(FLAGS_1\).*NOW", text):
        yield "no full RELRO"
    if "__stack_chk_fail" not in text:
        yield "no stack protector"
    if kind(path) == PROGRAM:
        yield "not position-independent"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hardened", action="store_true")
    parser.add_argument("--reproducible", action="store_true")
    parser.add_argument("paths", type=Path, nargs="+", metavar="FILE|FOLDER")
    arguments = parser.parse_args()
    found = list(binaries(arguments.paths))
    if not found:
        sys.exit(f"no binaries in {', '.join(map(str, arguments.paths))}")
    lines = [f"{path}: {fault}" for path in found for fault in faults(path, arguments.hardened, arguments.reproducible)]
    print("\n".join(lines), end="\n" if lines else "", file=sys.stderr)
    sys.exit(1 if lines else 0)


if __name__ == "__main__":
    main()
