#!/usr/bin/env python3
"""Renews the tables of a page from the commands that stand above them.

Usage: comparison_page.py PAGE [WORD]

A block of the page

    ```
    consimd compare ...
    ```
    <!-- tables -->
    ...
    <!-- end of tables -->

gets what the command writes to tables.md in place of the dots, and figures/NAME.svg beside the page, where the page
shows it, becomes the NAME.svg that a command draws. With a WORD only the commands that hold it are run. A
command that names an environment variable which is not set is left out, and so are its tables' changes. The page is
written after every command, so that what is done is kept.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(
    r"```\n(?P<command>consimd compare[^\n]*)\n```\n<!-- tables -->\n(?P<tables>.*?)<!-- end of tables -->\n", re.DOTALL
)


def tables_of(command, page):
    """What `command`, run in a folder of its own, writes to its tables.md. Its figures go to the page's."""
    with tempfile.TemporaryDirectory() as folder:
        words = [os.path.expandvars(word) for word in shlex.split(command)]
        subprocess.run([*words, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        for name in re.findall(r"\(figures/(\w+\.svg)\)", page.read_text()):
            if (drawn := Path(folder) / name).exists():
                shutil.copy(drawn, page.parent / "figures" / name)
        return (Path(folder) / "tables.md").read_text()


def unset_variables(command):
    return [name for name in re.findall(r"\$\{?(\w+)", command) if name not in os.environ]


def renew(page, word):
    commands = [match["command"] for match in BLOCK.finditer(page.read_text())]
    if not commands:
        raise SystemExit(f"{page}: no command with tables")
    chosen = [command for command in commands if word in command.removeprefix("consimd compare")]
    if not chosen:
        raise SystemExit(f"{page}: no command holds '{word}'")
    for command in chosen:
        if unset := unset_variables(command):
            print(f"left out, {', '.join(unset)} not set: {command}", file=sys.stderr)
            continue
        print(command, file=sys.stderr)
        tables = tables_of(command, page)
        text = BLOCK.sub(
            lambda match: match[0]
            if match["command"] != command
            else match[0].replace(f"<!-- tables -->\n{match['tables']}", f"<!-- tables -->\n\n{tables}\n"),
            page.read_text(),
        )
        page.write_text(text)


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__.strip())
    try:
        renew(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) == 3 else "")
    except subprocess.CalledProcessError as error:
        sys.exit(f"{shlex.join(error.cmd)} failed with exit status {error.returncode}")


if __name__ == "__main__":
    main()
