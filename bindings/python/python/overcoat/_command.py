"""The command `overcoat` of the wheel: the command line of the library, in the process of Python."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Runs the command line of this process; returns its exit code."""
    # Python notes Ctrl-C for later, and there is no later: the command ends by it as a program does. A closed pipe is an error
    # of a write, which the command reports, as Python has it already.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from . import _overcoat

    return _overcoat.run_command(["overcoat", *sys.argv[1:]])
