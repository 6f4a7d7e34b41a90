"""What the comparisons with other programs share: arguments, the cost of a command, and tables."""

import argparse
import os
import pathlib
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]


def parser(doc):
    """A parser with the text of a script as its help, and with --zonal."""
    p = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--zonal", default=os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target")) + "/release/zonal")
    return p


def cost(command):
    """Processor seconds and peak memory in MiB of a whole process."""
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{command[0]} ended with status {status}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def seconds_of(work):
    """What a call returns, and its processor seconds."""
    start = time.process_time()
    out = work()
    return out, time.process_time() - start


def row(*cells):
    """Prints a row of a table in Markdown."""
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def head(*names):
    """Prints the head of a table in Markdown."""
    row(*names)
    print("|---" * len(names) + "|")
