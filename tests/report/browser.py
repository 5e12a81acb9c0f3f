"""Headless Chromium through its DevTools protocol over a pipe: console, requests, screenshots."""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BINARY = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
FLAGS = ["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars", "--no-first-run",
         "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking",
         "--remote-debugging-pipe"]  # fmt: skip

# Chromium talks over file descriptors 3 and 4: a small program puts the pipe there and becomes Chromium
_LAUNCH = (
    "import os, sys; os.dup2(int(sys.argv[1]), 3); os.dup2(int(sys.argv[2]), 4); os.execv(sys.argv[3], sys.argv[3:])"
)
# what the software renderer of a machine without a graphics card says about itself, not about the page
_RENDERER = ("GPU stall due to ReadPixels", "Automatic fallback to software WebGL")


class Browser:
    """One page in Chromium; `console` holds its errors, warnings and uncaught exceptions, `requests` all addresses."""

    def __init__(self, width: int = 1280, height: int = 900) -> None:
        self.console: list[str] = []
        self.requests: list[str] = []
        self._loaded = False
        self._next, self._answers, self._rest = 0, {}, b""
        self._profile = tempfile.mkdtemp(prefix="chromium-")
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        high = [fcntl.fcntl(fd, fcntl.F_DUPFD, 20) for fd in (theirs_in, theirs_out)]
        size = f"--window-size={width},{height}"
        self._process = subprocess.Popen(
            [sys.executable, "-c", _LAUNCH, *map(str, high), BINARY, *FLAGS, f"--user-data-dir={self._profile}", size],
            pass_fds=high, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        for fd in (theirs_in, theirs_out, *high):
            os.close(fd)
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = None
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network", "Performance"):
            self._call(f"{domain}.enable")
        self.resize(width, height)

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._out)
        os.close(self._in)
        shutil.rmtree(self._profile, ignore_errors=True)

    def open(self, path: Path | str, settle: float = 0.5) -> None:
        """Load a file, or an address, and wait until it and its scripts have come to rest."""
        self._loaded = False
        is_address = isinstance(path, str) and path.startswith("http")
        self._call("Page.navigate", url=path if is_address else Path(path).resolve().as_uri())
        end = time.monotonic() + 60
        while not self._loaded and time.monotonic() < end:
            self._listen(0.2)
        assert self._loaded, "the page did not load within a minute"
        rest = time.monotonic() + settle
        while time.monotonic() < rest:
            self._listen(0.1)

    def evaluate(self, expression: str) -> object:
        """Value of a JavaScript expression; a promise is awaited."""
        answer = self._call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait_for(self, expression: str, seconds: float = 30) -> bool:
        """True as soon as an expression is true; False when it never was."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.evaluate(expression):
                return True
            time.sleep(0.1)
        return False

    def processor_seconds(self) -> float:
        """Processor time that the page's process has taken so far."""
        metrics = self._call("Performance.getMetrics")["metrics"]
        return next(metric["value"] for metric in metrics if metric["name"] == "ProcessTime")

    def resize(self, width: int, height: int) -> None:
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def media(self, media: str = "", scheme: str = "light") -> None:
        """Look like print or screen, light or dark."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self._call("Emulation.setEmulatedMedia", media=media, features=features)

    def screenshot(self, selector: str | None = None, whole: bool = False) -> bytes:
        """PNG of the window, of the whole page, or of one element."""
        options: dict = {"format": "png"}
        if selector:
            box = self.evaluate(
                f"(() => {{const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{behavior: "
                "'instant'}); const r = e.getBoundingClientRect(); return {x: r.x + scrollX, y: r.y + scrollY, "
                "width: r.width, height: r.height}})()"
            )
            options |= {"clip": box | {"scale": 1}, "captureBeyondViewport": True}
        elif whole:
            size = self._call("Page.getLayoutMetrics")["cssContentSize"]
            options |= {"clip": size | {"x": 0, "y": 0, "scale": 1}, "captureBeyondViewport": True}
        return base64.b64decode(self._call("Page.captureScreenshot", **options)["data"])

    def _call(self, method: str, **parameters: object) -> dict:
        self._next += 1
        message = {"id": self._next, "method": method, "params": parameters}
        if getattr(self, "_session", None):
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + 60
        while self._next not in self._answers:
            assert time.monotonic() < end, f"no answer to {method}"
            self._listen(0.5)
        answer = self._answers.pop(self._next)
        assert "error" not in answer, (method, answer)
        return answer["result"]

    def _listen(self, seconds: float) -> None:
        if not select.select([self._in], [], [], seconds)[0]:
            return
        chunk = os.read(self._in, 1 << 20)
        assert chunk, "Chromium ended"
        *whole, self._rest = (self._rest + chunk).split(b"\0")
        for text in whole:
            self._take(json.loads(text))

    def _take(self, message: dict) -> None:
        if "id" in message:
            self._answers[message["id"]] = message
            return
        method, told = message["method"], message.get("params", {})
        said = ""
        if method == "Page.loadEventFired":
            self._loaded = True
        elif method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            said = str(told["exceptionDetails"].get("exception", told["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            said = " ".join(str(part.get("value", part.get("description"))) for part in told["args"])
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            said = told["entry"]["text"]
        if said and not any(known in said for known in _RENDERER):
            self.console.append(said)
