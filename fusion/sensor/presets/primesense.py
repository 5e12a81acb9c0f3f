"""Cameras on PrimeSense's chip beside the first Kinect: Xtion, Carmine, Structure Sensor; and Apple's TrueDepth."""

from dataclasses import replace

from fusion.geometry.principle import Principle
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.presets.kinect_v1 import kinect_v1
from fusion.sensor.sensor import Sensor

SAME_CHIP = "the same chip and geometry as the Kinect v1 (OpenNI's cameras): taken over, not measured"
BREITBARTH = "Breitbarth et al. 2019, SPIE 11144: accuracies in the range of a millimetre"


def asus_xtion() -> Sensor:
    """ASUS Xtion Pro (Live)."""
    return _primesense("asus-xtion", "ASUS Xtion")


def primesense() -> Sensor:
    """PrimeSense Carmine 1.08."""
    return _primesense("primesense", "PrimeSense Carmine")


def structure_sensor() -> Sensor:
    """Occipital's first Structure Sensor."""
    return _primesense("structure-sensor", "Structure Sensor")


def iphone_truedepth() -> Sensor:
    """Front camera of an iPhone: projected dots at a short baseline that Apple does not state; noise is a guess."""
    return Sensor(
        "iphone-truedepth",
        Principle.STRUCTURED_LIGHT,
        (ProjectorShadow(baseline=0.027), LateralNoise(sigma_px=1.0), AxialNoise(c0=0.0, c1=0.0, c2=0.006)),
        sensor="iPhone TrueDepth",
        baseline=0.027,
        sources={
            "projector_shadow": "baseline 27 mm: pictures of opened phones, from memory; side: guess",
            "lateral_noise": "guess",
            "axial_noise": f"guess, about 1 mm at 0.4 m: {BREITBARTH}; growth with z^2: triangulation",
        },
    )


def _primesense(name: str, sensor: str) -> Sensor:
    kinect = kinect_v1()
    sources = {effect: f"{SAME_CHIP}; {source}" for effect, source in kinect.sources.items()}
    works = replace(kinect.works, source=f"{SAME_CHIP}; {kinect.works.source}")
    return replace(kinect, works=works, name=name, sensor=sensor, sources=sources)
