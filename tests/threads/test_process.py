"""As a library fusion leaves alone what other users of the process would notice.

What changes all the same, and is not looked at here: libraries that fusion imports set variables (OpenCV
LD_LIBRARY_PATH, Open3D TCM_ENABLE) and add filters of warnings; a started Taichi has threads of its own, tells errors
only, and keeps its kernels in a folder.
"""

import subprocess
import sys

import pytest

LOOK = """
import gc, inspect, os, sys, threading, warnings
import numpy as np

def flushed():  # numbers near 0 count as 0, as a processor can be told thread by thread
    return float(np.float32(1e-38) * np.float32(1e-3)) == 0.0

def look():
    found = {
        "environment": dict(os.environ), "collector": (gc.isenabled(), gc.get_threshold(), gc.get_freeze_count()),
        "inspect": {name: id(value) for name, value in vars(inspect).items() if callable(value)},
        "hooks": (sys.excepthook, sys.displayhook, sys.stdout, sys.stderr, sys.gettrace(), sys.getswitchinterval()),
        "warnings": ([str(entry) for entry in warnings.filters], warnings.showwarning), "numpy": np.geterr(),
        "folder": os.getcwd(), "random": np.random.get_state()[1].tobytes(), "flushed": flushed(),
        "threads": threading.active_count(),
    }
    if "taichi" in sys.modules:
        from taichi.lang import kernel_impl, misc
        from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext
        found["taichi"] = [
            {name: id(value) for name, value in vars(part).items() if callable(value)}
            for part in (kernel_impl, kernel_impl.Kernel, kernel_impl.Func, misc, ASTTransformerContext)
        ]
    return found

def compare(before, after):
    for name in before:
        assert before[name] == after[name], (name, before[name], after[name])
"""
ALL = """
for name in fusion.__all__:
    getattr(fusion, name)
"""
USE = """
import fusion
from fusion.geometry.depth import point_map
from fusion.tracking.icp import align

camera = fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
volume = fusion.Volume(fusion.VolumeSettings(voxel=0.01, truncation=0.04))
depth = np.ones(camera.shape, np.float32)
volume.integrate(depth, camera, np.eye(4))
volume.raycast(camera, np.eye(4))
volume.surface()
align(point_map(depth, camera), point_map(depth, camera), np.eye(4))
"""


def run(program: str) -> str:
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def test_beside_another_user_of_taichi_nothing_changes():
    others = "import cv2, open3d, scipy.optimize, scipy.special, matplotlib.figure, trimesh, taichi\n"
    told = run(f"{LOOK}\n{others}\nbefore = look()\n{USE}{ALL}\ncompare(before, look())\nprint('same')")
    assert told.splitlines()[-1] == "same"


def test_nothing_is_printed_no_variable_stays_and_threads_run_where_they_did():
    """Taichi is imported and started by fusion, from the module that needs most of it."""
    program = f"""
{LOOK}
import cv2
import fusion.compute.launch  # nothing of Taichi may be imported past the place that does it unheard

before = dict(os.environ)
cores = os.sched_getaffinity(0) if sys.platform == "linux" else None
{USE}
assert dict(os.environ) == before
assert not flushed()
if cores:
    assert all(os.sched_getaffinity(int(name)) == cores for name in os.listdir("/proc/self/task"))
"""
    assert run(program) == ""


@pytest.mark.parametrize("first", ["start", "kernel"])
def test_taichi_may_start_in_one_thread_and_work_in_others(first):
    """Kernels are compiled for the first time by several threads at once, whichever of them starts Taichi."""
    program = f"""
{LOOK}
from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.volume.volume import Volume, VolumeSettings

camera = Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
depth, failed = np.ones(camera.shape, np.float32), []

def fuse():
    volume = Volume(VolumeSettings(0.01, 0.04))
    volume.integrate(depth, camera, np.eye(4))
    volume.raycast(camera, np.eye(4))

def caught(call):
    try:
        call()
        assert not flushed()
    except Exception as error:
        failed.append(f"{{call.__name__}}: {{error!r}}")

def together(*calls):
    threads = [threading.Thread(target=caught, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

if {first!r} == "start":
    together(start)
together(fuse, lambda: point_map(depth, camera), fuse, lambda: point_map(depth, camera))
caught(fuse)
print(failed)
"""
    assert run(program).strip() == "[]"
