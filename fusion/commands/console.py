"""Where the console program begins: Ctrl-C is one line from here on, also while the rest is still being loaded."""

import os
import sys

STOPPED = 128  # and above: the status of a run that a signal ended


def run() -> int:
    """`fusion.commands.main.main`, from its import to its end."""
    sys.unraisablehook = _again
    try:
        import signal  # even this takes long enough to be interrupted

        from fusion.commands.main import main

        status = main()
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is done and told: what is left is Python's own end
    except KeyboardInterrupt:
        sys.stderr.write("fusion: interrupted\n")
        status = STOPPED + 2
    if status >= STOPPED or "usb1" in sys.modules:
        # at once: libraries that were stopped in the middle complain in their own ends, and change the status; and
        # libusb waits in its end, without limit, for a device that went away in the middle of a call
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except OSError:  # who reads went away
                continue
        os._exit(status)
    return status


def _again(lost: "sys.UnraisableHookArgs") -> None:
    """Ctrl-C in a callback, where Python can raise nothing, comes again a moment later."""
    if not isinstance(lost.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    import signal
    import threading

    # to this thread, so that it wakes from what it waits for
    threading.Timer(0.01, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT)).start()
