"""Blocks of code in pages of Markdown, with the marks in HTML comments before them.

Fenced blocks name their language; an indented block is one of the shell. A mark is a comment that stands before its block:

    <!-- test: skip: REASON -->                  the block is not run
    <!-- test: skip lines REGEX: REASON -->      lines of a block of the shell that match are not run
    <!-- test: file NAME -->                     the block of TOML is the scene NAME, which is checked; scene.toml without a mark
    <!-- test: add to NAME -->                   the block of TOML goes to the end of the scene NAME, which is checked
    <!-- test: text file NAME -->                the block is the file NAME, for later blocks
    <!-- test: shell … -->, python, toml NAME    a hidden block, the lines after the first one, which is run here
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

FENCE = re.compile(r"^( {0,3})```+\s*(\w*)\s*$")
MARK = re.compile(r"^<!--\s*test:\s*(.*?)\s*-->", re.S | re.M)
SHELL = {"sh", "bash", "console"}
# Blocks that are no code: output and formulas.
TEXT = {"text"}


@dataclass
class Block:
    """A block of code of a page."""

    line: int
    language: str
    code: str
    marks: list[str] = field(default_factory=list)


def blocks_of(page: Path) -> list[Block]:
    """The blocks of a page in order, hidden ones included."""
    lines = page.read_text(encoding="utf-8").split("\n")
    found: list[Block] = []
    marks: list[str] = []
    k = 0
    while k < len(lines):
        if lines[k].startswith("<!--"):
            end = next(j for j in range(k, len(lines)) if "-->" in lines[j])
            mark = MARK.match("\n".join(lines[k : end + 1]))
            if mark:
                head, _, body = mark[1].partition("\n")
                kind, _, name = head.partition(" ")
                if kind in ("shell", "python", "toml"):
                    found.append(Block(k + 1, "sh" if kind == "shell" else kind, body, [f"file {name}"] if name else []))
                else:
                    marks.append(mark[1].replace("\n", " "))
            k = end + 1
            continue
        fence = FENCE.match(lines[k])
        indented = lines[k].startswith("    ") and (k == 0 or not lines[k - 1].strip()) and not _is_in_list(lines, k)
        if fence:
            end = next(j for j in range(k + 1, len(lines)) if lines[j].strip().startswith("```"))
            code = [line.removeprefix(fence[1]) for line in lines[k + 1 : end]]
            found.append(Block(k + 1, fence[2], "\n".join(code) + "\n", marks))
            marks, k = [], end + 1
        elif indented:
            end = next((j for j in range(k, len(lines)) if lines[j].strip() and not lines[j].startswith("    ")), len(lines))
            code = "\n".join(line.removeprefix("    ") for line in lines[k:end]).rstrip() + "\n"
            found.append(Block(k + 1, "sh", code, marks))
            marks, k = [], end
        else:
            k += 1
    assert not marks, f"{page}: a mark stands before no block: {marks}"
    return found


def _is_in_list(lines: list[str], k: int) -> bool:
    """True for an indented line that continues an item of a list."""
    before = next((line for line in reversed(lines[:k]) if line.strip() and not line.startswith(" ")), "")
    return bool(re.match(r"([-*+]|\d+\.) ", before))
