"""The stage that makes the object: placed frames fused, its surface cleaned, how sure it is, its colours."""

from dataclasses import dataclass, replace

import numpy as np

from fusion.certainty.sigma import Sure
from fusion.coloring.color_mesh import Colored, color_mesh
from fusion.geometry.camera import Principle
from fusion.progress import stage
from fusion.scan.cleaning.clean import Cleaned, clean
from fusion.scan.cleaning.plate_light import PlateLight, plate_light, plate_reach, without
from fusion.scan.cleaning.seen import of_the_object
from fusion.scan.cleaning.touching import fused_untouched
from fusion.scan.judging.sure import MadeWith, scan_sigma
from fusion.scan.placing import PlacedFrames
from fusion.volume.volume import Volume


@dataclass(frozen=True)
class MadeObject:
    """The object."""

    placed: PlacedFrames  # frames that it was made of, and before them motion and recording
    volume: Volume  # of all frames
    cleaned: Cleaned  # its surface alone; `rough`: that of the frames as they were tracked freely
    rough: Cleaned
    colored: Colored  # with sigma, and with colours where these are asked for
    sure: Sure  # how sure each vertex is
    light: PlateLight | None = None  # what light by way of the plate does; None where it does nothing


def make(placed: PlacedFrames) -> MadeObject:
    """The object of the frames that were placed."""
    opened, seen = placed.found.opened, placed.found
    settings, motion = opened.settings, seen.motion
    volume = fused_untouched(placed.volume, seen.frames, placed.course.poses)
    with stage("mesh"):
        poses, by_hand = placed.course.poses, motion.shifts is not None
        surface = of_the_object(volume.surface(), seen.frames, poses, placed.volume.truncation, by_hand)
        both = surface, placed.free.volume.surface()
        cleaned, rough = (clean(one, settings, motion, placed.volume.voxel) for one in both)
        recording, light = seen.recording, None
        flies = recording.camera.principle == Principle.TIME_OF_FLIGHT
        if flies and motion.plate is not None and not settings.keep_plate and cleaned.mesh.normals is not None:
            first = int(np.flatnonzero(placed.course.valid)[0])
            object_reach = float(np.hypot(*cleaned.mesh.vertices[:, :2].T).max())
            radius = plate_reach(recording[first].depth, recording.camera, poses[first], object_reach)
            light = plate_light(cleaned.mesh, seen.frames, poses, radius, settings.plate_reflectance)
        if light is not None and light.taken_out:
            cleaned = replace(cleaned, mesh=without(cleaned.mesh, light))
    with stage("sigma"):
        used = MadeWith(seen.recording.camera, placed.found.focal, opened.sensor, settings.sensor, placed.volume)
        sure = scan_sigma(cleaned.mesh, seen.frames, placed.course.poses, used, motion)
    mesh = sure.onto(cleaned.mesh)
    colored = color_mesh(mesh, seen.recording, placed.course) if settings.color else Colored(mesh)
    return MadeObject(placed, volume, cleaned, rough, colored, sure, light)
