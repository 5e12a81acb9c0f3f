"""Makes a case: recordings and sensor model in a folder, and the label that is kept elsewhere."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from concealed import named
from concealed.flight import Flight
from concealed.oracle import Oracle, oracle_of
from concealed.plan import Plan, plan
from concealed.writing import entry, sensor_file, write_recording

ALIKE = 0.95
DRAWS = 5  # of a law whose form has free shape parameters, to span what it can look like


def make(family: str, seed: list[int], folder: Path) -> dict[str, Any]:
    """Write a case to `folder` (recordings, sensor.json); returns its label."""
    rng = np.random.default_rng(seed)
    case = plan(family, rng)
    folder.mkdir(parents=True)
    laws = [*case.known, *case.missing]
    about = {"scale": 1000 if case.flight else 5000, "mesh_sigma_m": case.mesh_sigma_m}
    about["telemetry"] = case.setting.kind == "warm"
    for i, shot in enumerate(case.shots):
        depth, amplitude = case.device.record(shot, laws, rng)
        write_recording(folder / f"rec_{i:02d}", shot, depth, amplitude, about)
    (folder / "sensor.json").write_text(sensor_file(_known(case), case.flight))
    return _label(case, seed)


def _known(case: Plan) -> list[dict[str, Any]]:
    device = case.device
    spread_only = {law.stage for law in case.missing}
    if isinstance(device, Flight):
        out = [
            entry("illumination_vignetting", exponent=(device.lamp, "1", 0.2)),
            entry("mixed_pixels", fill=(1.0, "1", 0.05)),
        ]
        noise = {"shot": (device.shot, "m", 9e-5), "floor": (device.floor, "m", 9e-5)}
        out.append(entry("axial_noise", **noise, ir_reference=(device.reference, "count", 0.0)))
        if "dark" not in spread_only:
            out.append(entry("amplitude_dropout", ir_threshold=(device.dark, "count", 5.0)))
        out.append(entry("saturation", ir_threshold=(device.bright, "count", 1000.0)))
        out.append(entry("depth_quantization", step=(0.001, "m", 0.0)))
    else:
        out = [
            entry("projector_shadow", baseline=(-0.075, "m", 0.0002)),
            entry("edge_fattening", window_px=(5.0, "px", 0.5)),
        ]
        frozen = {"sigma_px": (device.speckle, "px", 0.0033), "correlation_px": (5.0, "px", 1.0)}
        noise = {"sigma_px": (device.noise, "px", 0.00275), "correlation_px": (2.0, "px", 0.5)}
        out += [entry("speckle_noise", **frozen), entry("axial_noise", **noise)]
        out.append(entry("depth_quantization", step_px=(device.step, "px", 0.0)))
    if case.stated:
        out.append(entry(case.stated["name"], offset=(case.stated["value"], case.stated["unit"], case.stated["std"])))
    return out


def _label(case: Plan, seed: list[int]) -> dict[str, Any]:
    known = np.array([[case.stated["std"], 0.0]]) if case.stated else np.zeros((0, 2))
    label: dict[str, Any] = {"family": case.family, "seed": seed, "deck": case.setting.kind, "notes": case.notes}
    label |= {"principle": "itof" if case.flight else "structured_light", "nothing_missing": not case.missing}
    label |= {"z_o": 0.0, "missing": [], "equivalent": [], "accept_on_null": []}
    if case.setting.bow_m:
        label["accept_on_null"] = ["reference_shape_error"]
    label["known_truth"] = {case.stated["name"]: case.stated} if case.stated else {}
    oracle = None
    if any(law.channel == "bias" for law in case.missing):
        oracle = oracle_of(case.device, case.shots, known, case.mesh_sigma_m)
    for law in case.missing:
        z: float | None = None
        similar: dict[str, float] = {}
        if oracle is not None and law.channel == "bias":
            white = oracle.field([law], case.known)
            z = float(np.linalg.norm(white))
            similar = _similar(case, oracle, law.name, white) if case.family != "mixture" else {}
        one: dict[str, Any] = {
            "effect": law.name,
            "channel": law.channel,
            "variables": list(law.variables),
            "region": list(law.region),
        }
        one |= {"accept": list(law.accept), "form_shifted": law.shifted, "size": law.size, "z_o": z, "similar": similar}
        if law.parameter is not None and law.mask is None:
            one["parameters"] = {law.parameter[0]: {"value": law.parameter[1] * law.size}}
        label["missing"].append(one)
        label["equivalent"] += [name for name, cosine in similar.items() if cosine > ALIKE]
    found = [one["z_o"] for one in label["missing"] if one["z_o"] is not None]
    label["z_o"] = max(found, default=None if case.missing else 0.0)
    return json.loads(json.dumps(label))


def _similar(case: Plan, oracle: Oracle, name: str, white: NDArray[np.float64]) -> dict[str, float]:
    """Cosine between the true change and the nearest that another named law can make of it."""
    table = named.FLIGHT if case.flight else named.MATCHING
    rng = np.random.default_rng(0)
    out = {}
    for other, maker in table.items():
        if other == name or (other == "multipath" and case.setting.kind != "corner") or other == "fixed_pattern":
            continue
        free = other in ("cyclic_error", "disparity_distortion", "vertical_banding")
        columns = [oracle.field([maker(rng)], case.known) for _ in range(DRAWS if free else 1)]
        A = np.column_stack([c / max(float(np.linalg.norm(c)), 1e-12) for c in columns])
        fitted = A @ np.linalg.lstsq(A, white, rcond=1e-6)[0]
        out[other] = round(float(np.linalg.norm(fitted) / max(float(np.linalg.norm(white)), 1e-12)), 3)
    return {k: v for k, v in sorted(out.items(), key=lambda kv: -kv[1]) if v > 0.7}
