"""``python -m zonal``: the command ``zonal``, with its arguments and exit codes."""

from __future__ import annotations

import signal
import sys

from . import _zonal


def main() -> int:
    """Runs the command line of this process; returns its exit code."""
    # Ctrl-C ends the command as it ends the program `zonal`.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _zonal.run_command(["zonal", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
