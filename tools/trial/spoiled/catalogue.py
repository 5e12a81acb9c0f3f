"""All spoils by name, in the order in which they are run."""

from collections.abc import Callable

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told
from tools.trial.spoiled.numbers import noise_unsaid, rounded_undithered
from tools.trial.spoiled.places import centre_wrong, focal_wrong, mesh_wrong, poses_modest, poses_worse
from tools.trial.spoiled.replicas import copied, scenes_twice
from tools.trial.spoiled.surfaces import frames_shaken, walls_bowed
from tools.trial.spoiled.things import box_before, person_passing

CONTROL = "none"  # read and written, not spoiled


def unspoiled(case: Case, rng: Rng) -> Spoiled:
    """The case as it is."""
    return Spoiled(case, "", Told("^$"))


SPOILS: dict[str, Callable[[Case, Rng], Spoiled]] = {
    CONTROL: unspoiled,
    "poses": poses_worse,
    "centre": centre_wrong,
    "repeat": scenes_twice,
    "bow": walls_bowed,
    "clutter": box_before,
    "focal": focal_wrong,
    "copy": copied,
    "shake": frames_shaken,
    "modest": poses_modest,
    "noise": noise_unsaid,
    "person": person_passing,
    "rounding": rounded_undithered,
    "mesh": mesh_wrong,
}
OF_FILE = ("noise", "rounding")  # need a sensor.json, so not with a preset
