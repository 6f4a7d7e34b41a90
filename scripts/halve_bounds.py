#!/usr/bin/env python3
"""Halves each bound constant in turn and lists the first test that then fails.

A bound constant is a factor or a term of a proven error bound, on a line of crates/*/src that ends with the comment
`// bound`. If it can be halved and every test passes, either the bound has room to spare that nobody has measured, or the
test that should guard it is missing: both are worth a look.

    scripts/halve_bounds.py [--only FILE] [--list] [--target DIR] [--timeout SECONDS]

    --only FILE    only the constants of the files whose path contains FILE
    --list         name the constants and what they would become, run nothing
    --target DIR   where the copy and what cargo builds lie, kept for the next run (default: a temporary folder)
    --timeout S    seconds a test run may take (default 1800); longer counts as a failure named TIMEOUT

The tree is copied into a temporary folder (target folders, out and .git left out) and changed there, never in place. For each
constant the tests of the crate that it stands in run (`cargo test -p CRATE --lib`, then `--tests` if these all pass); the first failure
ends it. What is understood on
a tagged line: `const NAME: f64 = EXPR; // bound`, `let name = EXPR; // bound`, `place = EXPR; // bound`, a match arm
`pattern => EXPR, // bound`, `EXPR // bound` at the end of a block; arrays are halved entry by entry, integers by integer division.

Prints a table; ends with 1 if a constant survived, could not be read, or its halved form did not compile.
"""

# Guards (numbers): a constant of a bound stands on a line that ends with the comment `bound`; a test fails when it is halved (run by hand).

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TAG = re.compile(r"^(?P<code>.*\S)\s*// bound\s*$")


def constants(root, only):
    """(path, line number, code) of each tagged line."""
    for path in sorted(root.glob("crates/*/src/**/*.rs")):
        name = str(path.relative_to(root))
        if only and only not in name:
            continue
        for number, line in enumerate(path.read_text().splitlines()):
            tagged = TAG.match(line)
            if tagged:
                yield name, number, tagged["code"]


def entries(text):
    """The entries of `a, b(c, d), …` at the outermost level."""
    depth, start, out = 0, 0, []
    for i, c in enumerate(text):
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            out.append(text[start:i].strip())
            start = i + 1
    rest = text[start:].strip()
    return out + [rest] if rest else out


def half(expression, whole):
    """The expression halved: an array entry by entry, an integer by division."""
    expression = expression.strip()
    if expression.startswith("[") and expression.endswith("]") and ";" not in expression:
        return "[" + ", ".join(half(e, whole) for e in entries(expression[1:-1])) + "]"
    return f"(({expression}) / 2)" if whole else f"(0.5 * ({expression}))"


def halved(code):
    """The line with its value halved, or None where it is not understood."""
    forms = (
        r"^(?P<head>\s*(?:pub(?:\([a-z]+\))?\s+)?(?:const|static)\s+\w+\s*:\s*(?P<type>[^=]+?)\s*=\s*)(?P<value>.+)(?P<tail>;)$",
        r"^(?P<head>\s*let\s+\w+\s*=\s*\|[^|]*\|\s*)(?P<value>.+)(?P<tail>;)$",
        r"^(?P<head>\s*let\s+(?:mut\s+)?\w+\s*(?::\s*(?P<type>[^=]+?)\s*)?=\s*)(?P<value>.+)(?P<tail>;)$",
        r"^(?P<head>[^=]*=>\s*)(?P<value>[^{]+)(?P<tail>,)$",
        r"^(?P<head>\s*[\w.\[\]*]+\s*=\s*)(?P<value>.+)(?P<tail>;)$",
        r"^(?P<head>\s*[\w.\[\]*]+\s*\+=\s*)(?P<value>.+)(?P<tail>;)$",
        r"^(?P<head>\s*)(?P<value>[^;{}]+)(?P<tail>)$",
    )
    for form in forms:
        m = re.match(form, code)
        if m and balanced(m["value"]):
            kind = m.groupdict().get("type") or "f64"
            return m["head"] + half(m["value"], bool(re.search(r"\b[ui](8|16|32|64|128|size)\b", kind))) + m["tail"]
    return None


def balanced(text):
    depth = 0
    for c in text:
        depth += (c in "([{") - (c in ")]}")
        if depth < 0:
            return False
    return depth == 0


def failing(tree, target, crate, timeout):
    """The first failing test, SURVIVED, TIMEOUT or DOES NOT COMPILE."""
    for what in ("--lib", "--tests"):
        command = ["cargo", "test", "--quiet", "-p", crate, "--target-dir", str(target), what]
        try:
            run = subprocess.run(command, cwd=tree, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            return "TIMEOUT"
        if run.returncode:
            text = run.stdout + run.stderr
            named = re.search(r"^---- (\S+) stdout ----$", text, re.M)
            broken = re.search(r"^error(\[|: could not compile)", text, re.M)
            return named[1] if named else "DOES NOT COMPILE" if broken else "a test run that fails without a name"
    return "SURVIVED"


def copied(folder):
    """A fresh copy of the tree at one place of the folder: cargo takes what it built there before for what is there now."""
    tree = pathlib.Path(folder) / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    skip = shutil.ignore_patterns("target", "target-*", ".git", "out", "zonal-demo", "node_modules", "__pycache__")
    shutil.copytree(ROOT, tree, ignore=skip, symlinks=True)
    return tree


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--target", type=pathlib.Path)
    parser.add_argument("--timeout", type=float, default=1800)
    args = parser.parse_args()
    bad = 0
    if args.list:
        for name, number, code in constants(ROOT, args.only):
            new = halved(code)
            bad += new is None
            print(f"{name}:{number + 1}: {code.strip()}  ->  {new.strip() if new else 'NOT UNDERSTOOD'}")
        return bad > 0
    with tempfile.TemporaryDirectory(prefix="halve-bounds-") as folder:
        home = (args.target or pathlib.Path(folder)).resolve()
        tree, target = copied(home), home / "target"
        crates = sorted({name.split("/")[1] for name, _, _ in constants(tree, args.only)})
        for crate in crates:
            found = failing(tree, target, f"zonal-{crate}", args.timeout)
            if found != "SURVIVED":
                print(f"zonal-{crate} fails before anything is halved: {found}")
                return True
        print("| constant | first failing test |\n|---|---|", flush=True)
        for name, number, code in list(constants(tree, args.only)):
            new, path = halved(code), tree / name
            if new is None:
                result = "NOT UNDERSTOOD"
            else:
                before = path.read_text()
                lines = before.splitlines(keepends=True)
                lines[number] = new + "\n"
                path.write_text("".join(lines))
                crate = f"zonal-{name.split('/')[1]}"
                result = failing(tree, target, crate, args.timeout)
                path.write_text(before)
            bad += result in ("SURVIVED", "NOT UNDERSTOOD", "DOES NOT COMPILE")
            print(f"| {name}:{number + 1} `{code.strip()}` | {result} |", flush=True)
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
