"""Where the console program begins: Ctrl-C is one line from here on, also while the rest is still being loaded."""

import signal
import sys


def run() -> int:
    """`fusion.commands.main.main`, from its import to its end."""
    try:
        from fusion.commands.main import main

        status = main()
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is done and told: what is left is Python's own end
        return status
    except KeyboardInterrupt:
        sys.stderr.write("fusion: interrupted\n")
        return 130
