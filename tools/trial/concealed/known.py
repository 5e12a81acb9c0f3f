"""The part of the sensor model that the engine is given."""

from typing import Any

from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.matching import Matching
from tools.trial.concealed.plan import Plan
from tools.trial.concealed.writing import entry


def known_part(case: Plan) -> list[dict[str, Any]]:
    """Entries of `sensor.json`: all that is at work but what is concealed."""
    device, concealed = case.device, {law.stage for law in case.missing}
    out = _flight(device, concealed) if isinstance(device, Flight) else _matching(device)
    if case.stated:
        out.append(entry(case.stated["name"], offset=(case.stated["value"], case.stated["unit"], case.stated["std"])))
    return out


def _flight(device: Flight, concealed: set[str]) -> list[dict[str, Any]]:
    noise = {"shot": (device.shot, "m", 0.03 * device.shot), "floor": (device.floor, "m", 0.03 * device.floor)}
    axial = entry("axial_noise", **noise, ir_reference=(device.reference, "count", 0.0))
    if not device.simulated:
        return [axial]
    out = [
        entry("illumination_vignetting", exponent=(device.lamp, "1", 0.2)),
        entry("mixed_pixels", fill=(1.0, "1", 0.05)),
        axial,
    ]
    if "dark" not in concealed:
        out.append(entry("amplitude_dropout", ir_threshold=(device.dark, "count", 5.0)))
    if "bright" not in concealed:
        out.append(entry("saturation", ir_threshold=(device.bright, "count", 1000.0)))
    return [*out, entry("depth_quantization", step=(0.001, "m", 0.0))]


def _matching(device: Matching) -> list[dict[str, Any]]:
    frozen = {"sigma_px": (device.speckle, "px", 0.0033), "correlation_px": (5.0, "px", 1.0)}
    noise = {"sigma_px": (device.noise, "px", 0.00275), "correlation_px": (2.0, "px", 0.5)}
    return [
        entry("projector_shadow", baseline=(-0.075, "m", 0.0002)),
        entry("edge_fattening", window_px=(5.0, "px", 0.5)),
        entry("speckle_noise", **frozen),
        entry("axial_noise", **noise),
        entry("depth_quantization", step_px=(device.step, "px", 0.0)),
    ]
