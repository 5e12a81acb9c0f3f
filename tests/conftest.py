"""What every test may use."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

# figures are drawn to files; a test machine has no screen
os.environ.setdefault("MPLBACKEND", "Agg")
if "PYTEST_XDIST_WORKER" in os.environ:  # workers fill the cores already: threads inside them would only wait
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "TI_CPU_MAX_NUM_THREADS"):
        os.environ.setdefault(threads, "1")

PROJECT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder with the real recordings (`data`) and the challenges; the test is skipped where there is none."""
    stated = Path(os.environ.get("FUSION_SHARED") or "../shared")
    folder = (PROJECT / stated).resolve()
    if not (folder / "data").is_dir():
        pytest.skip(f"no recordings at {folder}/data: set FUSION_SHARED")
    return folder


@pytest.fixture
def trusting() -> Iterator[Callable[[float, bool], None]]:
    """Sets how far the process trusts what it reads, until the test is over."""
    from fusion.files.limits import USUAL_GB
    from fusion.files.trust import trust

    yield trust
    trust(USUAL_GB, False)
