"""Where the console program begins: Ctrl-C is one line from here on, also while the rest is still being loaded."""

import atexit
import os
import sys
from typing import NoReturn

STOPPED = 128  # and above: the status of a run that a signal ended


def run() -> NoReturn:
    """`fusion.commands.main.main`, from its import to the end of the process."""
    sys.unraisablehook = _again
    try:
        import signal  # even this takes long enough to be interrupted

        from fusion.commands.main import main

        status = main()
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is done and told: what is left is Python's own end
    except KeyboardInterrupt:
        sys.stderr.write("fusion: interrupted\n")
        status = STOPPED + 2
    leave(status)


def leave(status: int) -> NoReturn:
    """End the process at once: of a scan Python's own end, which gives all memory back piece by piece, takes 0.4 s.

    What libraries registered for their ends is called after a run that ended well: one that was stopped in the middle
    complains there, and changes the status, and libusb waits there, without limit, for a device that went away.
    """
    if status < STOPPED:
        if kernels := sys.modules.get("fusion.compute.start"):
            kernels.keep_kernels()
        if "usb1" not in sys.modules:
            atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # who reads went away
            continue
    os._exit(status)


def _again(lost: "sys.UnraisableHookArgs") -> None:
    """Ctrl-C in a callback, where Python can raise nothing, comes again a moment later."""
    if not isinstance(lost.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    import signal
    import threading

    # to this thread, so that it wakes from what it waits for
    threading.Timer(0.01, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT)).start()
