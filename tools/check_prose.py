#!/usr/bin/env python3
"""Fails where a page in Markdown has prose wider than 100 columns, or links to a file or heading that is not there.

Usage: check_prose.py PAGE...

Code, tables, headings, pictures and what `./dev compare --page` writes may be as wide as they are.
"""

import re
import sys
from pathlib import Path

WIDTH = 100
LINK = re.compile(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)")


def prose(page):
    """(number, line) of every line that is prose, or a heading, table or picture if it is not `wide`."""
    code = written = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if line.lstrip().startswith("```"):
            code = not code
        elif line.startswith("<!-- tables"):
            written = True
        elif line.startswith("<!-- end of tables"):
            written = False
        elif not code and not written:
            yield number, line


def anchors(page):
    """The anchors of the headings, as GitHub makes them."""
    for _, line in prose(page):
        if heading := re.match(r"#+ (.*)", line):
            yield re.sub(r"[^\w\- ]", "", heading[1].lower()).replace(" ", "-")


def faults(page):
    for number, line in prose(page):
        if len(line) > WIDTH and not line.lstrip().startswith(("|", "#", "![")):
            yield f"{page}:{number}: {len(line)} columns, at most {WIDTH}"
        for file, anchor in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            if file.startswith(("http:", "https:")):
                continue
            target = page.parent / file if file else page
            if not target.exists():
                yield f"{page}:{number}: no file {file}"
            elif anchor and anchor not in anchors(target):
                yield f"{page}:{number}: no heading #{anchor} in {target.name}"


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    found = [fault for page in sys.argv[1:] for fault in faults(Path(page))]
    for fault in found:
        print(fault, file=sys.stderr)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
