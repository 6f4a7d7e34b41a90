#!/usr/bin/env python3
"""third_party.py [--check]: the licences of the crates in the wheel, from the metadata and the sources of cargo.

Writes python/THIRD-PARTY-LICENSES.md, which is part of the wheels of all systems; --check compares instead and ends with 1 where it differs. Texts that are
the same but for blanks are written once. scripts/archive.py writes the same page for the command.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
TARGET = ROOT / "python/THIRD-PARTY-LICENSES.md"
# Systems for which release.yml makes wheels.
TARGETS = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-apple-darwin", "aarch64-apple-darwin", "x86_64-pc-windows-msvc"]
# Crates that run at build time alone and are no part of the wheel keep their place: they are few, and the list is then that of cargo.
NAMES = re.compile(r"(?i)^(licen[cs]e|copying|unlicense|notice)([-._].*)?$")


def packages(root, targets):
    """All packages on which a package depends for some target, but those of this workspace, by name and version."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", *(w for t in targets for w in ("--filter-platform", t))]
    data = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    by_id = {p["id"]: p for p in data["packages"]}
    nodes = {n["id"]: n for n in data["resolve"]["nodes"]}
    open_ids = [p["id"] for p in data["packages"] if p["name"] == root]
    found = set()
    while open_ids:
        node = open_ids.pop()
        if node in found:
            continue
        found.add(node)
        for dep in nodes[node]["deps"]:
            if any(k["kind"] is None for k in dep["dep_kinds"]):
                open_ids.append(dep["pkg"])
    chosen = [by_id[i] for i in found if by_id[i]["source"] is not None]
    return sorted(chosen, key=lambda p: (p["name"], p["version"]))


def text(root="zonal-python", targets=TARGETS):
    lines = [
        "# Licences of the crates in this package",
        "",
        "The program or native module `zonal` contains these crates. Written by `scripts/third_party.py`.",
        "",
        "| crate | version | licence | texts |",
        "|---|---|---|---|",
    ]
    number, texts = {}, []
    for p in packages(root, targets):
        folder = pathlib.Path(p["manifest_path"]).parent
        own = []
        for file in sorted(folder.iterdir()):
            if file.is_file() and NAMES.match(file.name):
                content = file.read_text(encoding="utf-8", errors="replace").strip().replace("\r\n", "\n")
                key = " ".join(content.split())
                if key not in number:
                    number[key] = len(texts) + 1
                    texts.append(content)
                own.append(number[key])
        licence = p["license"] or "see its text"
        lines.append(f"| {p['name']} | {p['version']} | {licence} | {', '.join(map(str, own)) or 'none in its package'} |")
    for k, content in enumerate(texts, start=1):
        fence = "```" + "`" * content.count("```")
        lines += ["", f"## {k}", "", f"{fence}text", *(line.rstrip() for line in content.splitlines()), fence]
    return "\n".join(lines) + "\n"


def main():
    wanted = text()
    if "--check" not in sys.argv[1:]:
        TARGET.write_text(wanted, encoding="utf-8")
        return 0
    if TARGET.exists() and TARGET.read_text(encoding="utf-8") == wanted:
        return 0
    print(f"{TARGET.relative_to(ROOT)} is out of date; run scripts/third_party.py", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
