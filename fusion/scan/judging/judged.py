"""The last stage of a scan: what speaks for and against it, and the result."""

from fusion.printing.faults import thin_share
from fusion.progress import stage
from fusion.results.choices import LensUsed, RegionFound, ScanChoices
from fusion.results.color_light import color_lights
from fusion.scan.finding.object import typical_noise
from fusion.scan.judging.agreement import agreement
from fusion.scan.judging.evidence import Evidence
from fusion.scan.judging.missed import closing_gaps, confirmed
from fusion.scan.judging.notes import notes_of
from fusion.scan.judging.print_agreement import print_agreement
from fusion.scan.judging.pulled import pulled
from fusion.scan.making import MadeObject
from fusion.scan.result import Scan
from fusion.turntable.jumps import find_jump


def judged(made: MadeObject) -> Scan:
    """The result, with the evidence that its judgement rests on."""
    placed, free, course = made.placed, made.placed.free, made.placed.course
    seen, motion, opened = placed.found, placed.found.motion, placed.found.opened
    frames, region, camera = seen.frames, seen.region, seen.recording.camera
    chosen = _chosen(made)
    with stage("judging"):
        agreed = agreement(made.volume, frames, course.poses, motion)
        cut = region.cut(region.window(camera))
        prints = print_agreement(frames, cut, course.poses, motion.angles)
        asked = pulled(made.cleaned.mesh, frames, course.poses, motion, cut, placed.volume.truncation)
    jump = find_jump(free.course.poses, course.poses, made.cleaned.mesh.vertices.mean(axis=0))
    gaps = closing_gaps(frames, region, (course, free.course), motion.angles)
    jump = confirmed(jump, frames, region, course)
    return Scan(
        mesh=made.colored.mesh,
        mesh_raw=made.rough.mesh,
        trajectory=course,
        trajectory_raw=free.course,
        motion=motion,
        steps=placed.steps,
        circle=placed.circle,
        closure=gaps[0],
        closure_raw=gaps[1],
        residual=free.residual,
        inlier_share=free.inlier_share,
        wobble=placed.wobble,
        camera=camera,
        settings=chosen,
        told=seen.told,
        sure=made.sure,
        evidence=Evidence(
            stated_camera=opened.stated,
            focal=placed.found.focal,
            refined=camera != opened.stated,
            jump=jump,
            noise=typical_noise(frames, region),
            kept_share=made.cleaned.kept,
            hidden=made.cleaned.hidden,
            thin_share=thin_share(made.colored.mesh, made.volume.settings.truncation),
            agreement=agreed,
            print=prints,
            pulled=asked,
            notes=(
                *opened.doubts,
                *notes_of(seen.recording, opened.correction, motion, free.course),
                *color_lights(made.colored),
            ),
            footnotes=(
                *opened.sensor.warnings,
                *opened.correction.left,
                *(() if made.light is None else (str(made.light),)),
            ),
        ),
    )


def _chosen(made: MadeObject) -> ScanChoices:
    opened, seen = made.placed.found.opened, made.placed.found
    asked, region = opened.settings, seen.region
    return ScanChoices(
        **vars(made.colored.figures()),
        box=asked.box,
        mask=asked.mask,
        step=asked.step,
        use_log=asked.use_log,
        strength=asked.strength,
        refine_camera=asked.refine_camera,
        keep_plate=asked.keep_plate,
        force=asked.force,
        fill_holes=asked.fill_holes,
        sensor=opened.sensor.name,
        sensor_assumed=asked.sensor is None,
        correction=opened.correction.figures(),
        voxel_m=made.volume.settings.voxel,
        truncation_m=made.volume.settings.truncation,
        camera=LensUsed.of(seen.recording.camera),
        region=RegionFound(region.low.tolist(), region.high.tolist()),
        volume_bytes=made.volume.bytes,
    )
