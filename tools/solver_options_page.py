#!/usr/bin/env python3
"""Prints the page docs/solver_options.md, from what the command says of its solvers.

Usage: solver_options_page.py CONSIMD >docs/solver_options.md
"""

import json
import subprocess
import sys
import textwrap

HEAD = """\
# Options of the solvers

Every solver takes a noise bound and a seed. What it has beside them is listed here; defaults are
good for most data. In C++ they are members of the solver's options struct, in Python keyword
arguments of `consimd.register`. On the command line:

```
consimd register pair.txt --solver ransac --option max_iterations=10000 --option confidence=none
consimd sweep --solver ransac:max_iterations=10000:confidence=none,teaser:refine=false,tcf
```

This page is written by `tools/solver_options_page.py` from `consimd info --solver NAME --json`.
"""


def said(consimd, *arguments):
    return json.loads(subprocess.check_output([consimd, "info", *arguments, "--json"], text=True))


def text_of(value):
    if value is None:
        return "none"
    return json.dumps(value).strip('"')


def section(solver):
    description = f"{solver['description'][0].upper()}{solver['description'][1:]}."
    yield f"\n## `{solver['name']}`\n\n{textwrap.fill(description, 100, break_on_hyphens=False)}\n"
    for preset in solver["presets"]:
        settings = ", ".join(f"`{name}={text_of(value)}`" for name, value in preset["options"].items())
        yield f"\nPreset `{preset['name']}`: {settings}.\n"
    yield "\n| option | default | unit | values | meaning |\n|---|---|---|---|---|\n"
    for option in solver["options"]:
        cells = (f"`{option['name']}`", f"`{text_of(option['value'])}`", option["unit"], option["expected"])
        yield f"| {' | '.join((*cells, option['meaning'].replace('|', chr(92) + '|')))} |\n"


def page(consimd):
    solvers = [said(consimd, "--solver", name) for name in said(consimd)["solvers"]]
    # A preset is told of with its solver.
    parts = (part for solver in solvers if solver["solver"] == solver["name"] for part in section(solver))
    return HEAD + "".join(parts)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    sys.stdout.write(page(sys.argv[1]))
