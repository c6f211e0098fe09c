#!/usr/bin/env python3
"""Batches of sources that clang-tidy reads at once, since most of its time goes into the headers that they share.

tidy_batches.py DATABASE_FOLDER OUT_FOLDER: of DATABASE_FOLDER/compile_commands.json, writes to OUT_FOLDER a source for each
batch, which includes up to eight sources that are compiled alike, and their compile_commands.json. Sources that define the
same name at namespace scope, as those in unnamed namespaces may, come into different batches.
"""

import json
import re
import shutil
import sys
from pathlib import Path

MOST = 8
COMMENT = re.compile(r"//[^\n]*")
DEFINED = re.compile(
    r"^(?:template\b[^\n]*>\s*)?(?:struct|class|enum|enum class)\s+(\w+)\b"
    r"|^using\s+(\w+)\s*="
    r"|^(?!namespace\b)(?:\[\[\w+\]\]\s*|inline\s+|static\s+|constexpr\s+|const\s+)*[\w:][\w:<>,&*\s]*[\s&*](\w+)(?:\(|\[|\{|\s=)",
    re.MULTILINE,
)


def names(source):
    text = COMMENT.sub("", Path(source).read_text())
    return {name for match in DEFINED.finditer(text) for name in match.groups() if name and not name.isupper()}


def flags(entry):
    words = entry["command"].split()
    output = words.index("-o")
    return " ".join(word for k, word in enumerate(words) if k not in (output, output + 1) and word != entry["file"])


def main():
    database, out = Path(sys.argv[1]), Path(sys.argv[2])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    batches = {}  # of flags: (names, sources)
    seen = set()
    for entry in json.loads((database / "compile_commands.json").read_text()):
        if entry["file"] in seen or Path(entry["file"]).is_relative_to(database):
            continue
        seen.add(entry["file"])
        alike = batches.setdefault((entry["directory"], flags(entry)), [])
        defined = names(entry["file"])
        for known, sources in alike:
            if len(sources) < MOST and not known & defined:
                known |= defined
                sources.append(entry["file"])
                break
        else:
            alike.append((defined, [entry["file"]]))
    commands = []
    for (directory, compiler), alike in batches.items():
        for _, sources in alike:
            batch = out / f"batch_{len(commands)}.cpp"
            batch.write_text("".join(f'#include "{source}"\n' for source in sources))
            commands.append({"directory": directory, "command": f"{compiler} {batch}", "file": str(batch)})
    (out / "compile_commands.json").write_text(json.dumps(commands, indent=1))


main()
