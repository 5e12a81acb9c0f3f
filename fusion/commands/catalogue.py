"""Every command: what it does, and in which folder here its file stands; none is loaded before it is called."""

import importlib
from types import ModuleType

# command: what it does, in the order of the work
COMMANDS = {
    "demo": "the whole main job on an object that the program makes itself",
    "record": "from a camera, or from a recording played back, frame by frame into a new recording",
    "live": "the same while the object is seen growing; then a result as of `fusion turntable`",
    "info": "what is in a recording, and what looks wrong with it",
    "convert": "between recording formats, and between mesh formats",
    "reconstruct": "correct, track, integrate: a recording becomes a mesh",
    "turntable": "the same for an object on a turntable, with axis and closed loop",
    "merge": "several passes of one object, turned over between them, become one",
    "texture": "the colour images of a scan, laid on its mesh as a picture: GLB, OBJ, USDZ",
    "batch": "a command over many recordings: a row, a folder and a picture for each",
    "simulate": "a recording as a sensor would have made it; the same seed, the same bits",
    "sensor": "a sensor model as a table with units and sources, for other simulators, or beside another one",
    "calibrate": "camera, depth or noise from recordings of boards and walls",
    "evaluate": "the sensor bench: noise, offset, shares, steps and drift of still recordings",
    "explain": "where simulation and recording differ, which physics is missing, and the better model",
    "compare": "signed distances between a mesh and a reference",
    "doctor": "what is plugged in, installed, missing; whether a camera gives what it should",
    "repeat": "several scans of one object: how far they spread, and where",
    "completion": "what a shell needs to complete commands and options with the Tab key",
}

# folder: its commands; the others stand beside this file
_FOLDERS = {
    "scan": "demo live turntable reconstruct merge texture batch",
    "recording": "record info convert simulate doctor",
    "camera": "calibrate evaluate explain sensor",
    "mesh": "compare repeat",
}
_FOLDER = {name: f"{folder}." for folder, names in _FOLDERS.items() for name in names.split()}


def load(name: str) -> ModuleType:
    """The module of a command: `EXAMPLE`, `add_arguments`, `run`, and `check` where something is asked before."""
    return importlib.import_module(f"fusion.commands.{_FOLDER.get(name, '')}{name}")
