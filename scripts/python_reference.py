#!/usr/bin/env python3
"""python_reference.py OUTPUT.md: the reference of the Python package for the manual, from its signatures and docstrings.

Needs the package to be importable. The result is committed as docs/reference/python.md; CI compares it.
"""

import dataclasses
import inspect
import re
import sys

import zonal

HEADER = """# Python package

`import zonal as zn`. The [tutorial](../tutorials/python.md) introduces it. Written by `scripts/python_reference.py` from the docstrings.

"""
# Names in the order of the page.
ORDER = [
    "view_factors", "ViewFactors", "CompressedRows", "load_scene", "Scene", "Gas", "Solution", "Diagnostic", "Timings", "Phase", "Camera", "load_solution", "encode_png", "show", "Dataset", "load_dataset", "ExchangeAreas", "StateSolver", "ThermalState", "update",
    "gas_properties", "keys", "Key", "validate", "Error", "InputError", "FileError", "MemoryLimitError", "Interrupted",
]  # fmt: skip
# Long signatures are written over several lines.
MAX_SIGNATURE = 120


def signature(name, function):
    """`name(arguments) -> result`, without quotes around types."""
    text = str(inspect.signature(function)).replace("self, ", "", 1).replace("(self)", "()", 1)
    text = re.sub(r"['\"]", "", text) if "= '" not in text else re.sub(r"(?<=: )'([^']*)'", r"\1", text)
    whole = f"{name}{text}"
    if len(whole) <= MAX_SIGNATURE:
        return whole
    head, _, rest = whole.partition("(")
    inner, _, result = rest.rpartition(")")
    parts, depth, start = [], 0, 0
    for k, c in enumerate(inner):
        depth += (c in "[(") - (c in "])")
        if c == "," and depth == 0:
            parts.append(inner[start:k].strip())
            start = k + 1
    parts.append(inner[start:].strip())
    return head + "(\n" + "".join(f"    {p},\n" for p in parts) + ")" + result


def prose(doc):
    """A docstring as Markdown: sections as bold words, references as code, examples as blocks."""
    lines, out, in_example = inspect.cleandoc(doc or "").splitlines(), [], False
    for k, line in enumerate(lines):
        line = re.sub(r":\w+:`~?\.?([^`]*)`", r"`\1`", line)
        if k + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[k + 1]):
            out += [f"**{line}**", ""]
            continue
        if re.fullmatch(r"-{3,}", line):
            continue
        is_code = line.startswith((">>>", "..."))
        if is_code and not in_example:
            out.append("```pycon")
            in_example = True
        if in_example and not line.strip():
            out.append("```")
            in_example = False
        if in_example:
            out.append(line)
        elif line.startswith("    "):
            out.append(f"  {line.strip()}")
        elif re.match(r"[\w*][\w, *]*( : .*)?$", line) and k + 1 < len(lines) and lines[k + 1].startswith("    "):
            name, _, kind = line.partition(" : ")
            out.append(f"- `{name}`" + (f": {kind}" if kind else "") + "  ")
        else:
            out.append(line)
    if in_example:
        out.append("```")
    return "\n".join(out).strip()


def members(cls):
    """Public methods and properties in the order of the source."""
    for name, value in vars(cls).items():
        if name.startswith("_"):
            continue
        if isinstance(value, property):
            yield f"### {cls.__name__}.{name}", None, value.__doc__
        elif inspect.isfunction(value) or isinstance(value, (staticmethod, classmethod)):
            function = value.__func__ if isinstance(value, (staticmethod, classmethod)) else value
            yield f"### {cls.__name__}.{name}", signature(name, function), function.__doc__


def page():
    assert sorted(ORDER) == sorted(zonal.__all__), set(ORDER) ^ set(zonal.__all__)
    out = [HEADER.rstrip()]
    for name in ORDER:
        value = getattr(zonal, name)
        is_class = inspect.isclass(value)
        out += ["", f"## {name}", ""]
        has_own = not is_class or "__init__" in vars(value) or dataclasses.is_dataclass(value)
        if has_own and name not in ("Solution", "ExchangeAreas", "ViewFactors"):
            target = value.__init__ if is_class else value
            out += ["```python", signature(name, target).replace(" -> None", "" if is_class else " -> None"), "```", ""]
        out.append(prose(value.__doc__))
        if is_class and not issubclass(value, tuple):
            for title, text, doc in members(value):
                out += ["", title, ""]
                if text:
                    out += ["```python", text, "```", ""]
                out.append(prose(doc))
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(page())
