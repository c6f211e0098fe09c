#!/usr/bin/env python3
"""Names that a source brings in and does not use: using-declarations and namespace aliases.

check_using.py FILE...: exit status 1 and a line per fault. clang-tidy's misc-unused-using-decls and misc-unused-alias-decls
look at the main file alone, which is none of the project's where it reads several sources at once.
"""

import re
import sys
from pathlib import Path

BROUGHT_IN = re.compile(r"^\s*(?:using\s+(?:typename\s+)?(?:::)?(?:\w+::)+(\w+);|namespace\s+(\w+)\s*=)", re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)

faults = 0
for name in sys.argv[1:]:
    text = COMMENT.sub("", Path(name).read_text())
    for match in BROUGHT_IN.finditer(text):
        brought_in = match.group(1) or match.group(2)
        if len(re.findall(rf"\b{brought_in}\b", text)) < 2:
            print(f"{name}:{text.count(chr(10), 0, match.start(match.lastindex)) + 1}: '{brought_in}' is not used")
            faults += 1
sys.exit(faults > 0)
