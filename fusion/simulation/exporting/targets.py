"""The simulators that a sensor model can be exported to, each with the law that it publishes."""

import json

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.target import Floats, Parameters, SimulatorTarget, StatedWall, weighted

NEAR, FAR = 0.2, 10.0  # [m] clipping planes where a simulator asks for some and the sensor has no working range
DISPARITY_PX_M, REDWOOD_STEP, REDWOOD_SIGMA = 35.130, 1 / 8, 0.027778  # px m, px, px: of the habitat-sim source
AZURE_BASE, AZURE_SLOPE, AZURE_FROM = 5e-4, 1e-3, 0.5  # m, 1, m: of the BlenderProc source
BUFFER_BITS = 24  # of MuJoCo's depth buffer


def isaac() -> SimulatorTarget:
    """Isaac Sim's single-view depth camera: Gaussian noise of the disparity."""

    def fit(sensor: Sensor, camera: Camera, stated: StatedWall) -> Parameters:
        fb = camera.fx * (abs(sensor.baseline) or 0.05)
        near, far = _limits(sensor)
        # in disparity both laws are constants: the depths count alike there
        per_px = stated.depths**2 / fb
        mean = weighted(stated.mean_bias, -per_px, per_px**-2.0)
        sigma = weighted(stated.rms_sigma, per_px, per_px**-2.0)
        return {
            "baselineMM": 1000 * fb / camera.fx,
            "focalLengthPixel": camera.fx,
            "noiseMean": mean,
            "noiseSigma": sigma,
            "minDistance": near,
            "maxDistance": far,
        }

    def moments(given: Parameters, depth: Floats) -> tuple[Floats, Floats]:
        per_px = depth**2 / (given["baselineMM"] / 1000 * given["focalLengthPixel"])
        share = given["noiseSigma"] * per_px / depth  # of the disparity
        # f b / (d + n) to the second order in n
        return -given["noiseMean"] * per_px + depth * share**2, given["noiseSigma"] * per_px

    def text(camera: Camera, given: Parameters, about: list[str]) -> str:
        lines = ["#usda 1.0", *(f"# {line}" for line in about), 'over "Camera" (']
        lines += ['    prepend apiSchemas = ["OmniSensorDepthSensorSingleViewAPI"]', ")", "{"]
        lines += ["    bool omni:rtx:post:depthSensor:enabled = 1"]
        lines += [f"    float omni:rtx:post:depthSensor:{name} = {value:.9g}" for name, value in given.items()]
        lines += [f"    float omni:rtx:post:depthSensor:sensorSizePixel = {camera.width}", "}", ""]
        return "\n".join(lines)

    return SimulatorTarget(
        "isaac",
        "z = f b / (f b / z + n), n ~ N(noiseMean, noiseSigma) [px]",
        "nvidia-omniverse.github.io/ovrtx, Camera single-view stereo depth model; "
        "docs.isaacsim.omniverse.nvidia.com, Depth Sensors",
        fit,
        moments,
        text,
        ("axial_noise", "disparity_offset", "projector_shadow", "speckle_noise"),
        "holes where its own matcher would fail, and its rounding of the disparity",
    )


def gazebo() -> SimulatorTarget:
    """Gazebo's depth camera: Gaussian noise of the depth, the same at all depths."""

    def fit(sensor: Sensor, camera: Camera, stated: StatedWall) -> Parameters:
        known = np.isfinite(stated.mean_bias)
        mean = float(stated.mean_bias[known].mean()) if known.any() else 0.0
        stddev = float(stated.rms_sigma[known].mean()) if known.any() else 0.0
        near, far = _limits(sensor)
        return {"mean": mean, "stddev": stddev, "near": near, "far": far}

    def moments(given: Parameters, depth: Floats) -> tuple[Floats, Floats]:
        return np.full_like(depth, given["mean"]), np.full_like(depth, given["stddev"])

    def text(camera: Camera, given: Parameters, about: list[str]) -> str:
        angle = 2 * np.arctan(camera.width / (2 * camera.fx))
        lens = "".join(
            f"<{name}>{value:.9g}</{name}>"
            for name, value in zip(("k1", "k2", "p1", "p2", "k3"), camera.distortion, strict=False)
        )
        inner = [
            f"<horizontal_fov>{angle:.9g}</horizontal_fov>",
            f"<image><width>{camera.width}</width><height>{camera.height}</height><format>R_FLOAT32</format></image>",
            f"<clip><near>{given['near']:g}</near><far>{given['far']:g}</far></clip>",
            f"<noise><type>gaussian</type><mean>{given['mean']:.9g}</mean><stddev>{given['stddev']:.9g}</stddev></noise>",
            f"<distortion>{lens}<center>0.5 0.5</center></distortion>",
            f"<lens><intrinsics><fx>{camera.fx:.9g}</fx><fy>{camera.fy:.9g}</fy><cx>{camera.cx:.9g}</cx>"
            f"<cy>{camera.cy:.9g}</cy><s>0</s></intrinsics></lens>",
        ]
        body = "\n".join(f"    {line}" for line in inner)
        told = "\n".join(f"  {line}" for line in about).replace("--", "- -")
        start = '<sensor name="depth" type="depth_camera">'
        return f"<!--\n{told}\n-->\n{start}\n  <camera>\n{body}\n  </camera>\n</sensor>\n"

    return SimulatorTarget(
        "gazebo",
        "z + n, n ~ N(mean, stddev) [m]",
        "github gazebosim/gz-sensors, src/DepthCameraSensor.cc: ImageGaussianNoiseModel of <noise>",
        fit,
        moments,
        text,
        ("axial_noise", "depth_offset", "lens_distortion", "focal_length", "principal_point"),
    )


def habitat() -> SimulatorTarget:
    """Habitat's Redwood model of the first Kinect, with its one number."""

    def fit(sensor: Sensor, camera: Camera, stated: StatedWall) -> Parameters:
        per_px = stated.depths**2 / DISPARITY_PX_M
        # what its rounding makes anyway is not noise that must be added
        left = np.sqrt(np.maximum(stated.rms_sigma**2 - (REDWOOD_STEP**2 / 12) * per_px**2, 0))
        return {"noise_multiplier": weighted(left, per_px, per_px**-2.0) / REDWOOD_SIGMA}

    def moments(given: Parameters, depth: Floats) -> tuple[Floats, Floats]:
        disparity = DISPARITY_PX_M / depth
        sigma = REDWOOD_SIGMA * given["noise_multiplier"]
        low = np.floor(disparity / REDWOOD_STEP)
        steps = (low[..., None] + np.arange(-12, 14)) * REDWOOD_STEP
        edges = np.concatenate([steps - REDWOOD_STEP / 2, steps[..., -1:] + REDWOOD_STEP / 2], axis=-1)
        share = np.diff(_below((edges - disparity[..., None]) / max(sigma, 1e-9)), axis=-1)
        share = np.where(steps > 0, share, 0)
        seen = DISPARITY_PX_M / np.maximum(steps, REDWOOD_STEP)
        mean = (share * seen).sum(axis=-1) / share.sum(axis=-1)
        spread = np.sqrt((share * (seen - mean[..., None]) ** 2).sum(axis=-1) / share.sum(axis=-1))
        return mean - depth, spread

    def text(camera: Camera, given: Parameters, about: list[str]) -> str:
        angle = float(np.rad2deg(2 * np.arctan(camera.width / (2 * camera.fx))))
        content = {
            "about": about,
            "sensor_type": "DEPTH",
            "resolution": [camera.height, camera.width],
            "hfov": angle,
            "noise_model": "RedwoodDepthNoiseModel",
            "noise_model_kwargs": given,
        }
        return json.dumps(content, indent=1) + "\n"

    return SimulatorTarget(
        "habitat",
        "z = 35.130 / (round(8 (35.130 / z + 0.027778 m n)) / 8), n ~ N(0, 1); pixels jitter by 0.25 m px",
        "github facebookresearch/habitat-sim, sensors/noise_models/redwood_depth_noise_model.py",
        fit,
        moments,
        text,
        ("axial_noise", "depth_quantization", "lateral_noise", "speckle_noise"),
        "the distortion of the one Kinect that its table holds, and half the resolution",
    )


def blenderproc() -> SimulatorTarget:
    """BlenderProc's Azure Kinect noise, whose law of the depth is fixed; the jitter of pixels can be told."""

    def fit(sensor: Sensor, camera: Camera, stated: StatedWall) -> Parameters:
        _, azure = moments({"add_kinect_azure_noise": 1.0}, stated.depths)
        known = np.isfinite(stated.rms_sigma)
        with_noise = np.sum((stated.rms_sigma - azure)[known] ** 2)
        without = np.sum(stated.rms_sigma[known] ** 2)
        jitter = sensor.effect("lateral_noise")
        at = float(np.nanmedian(stated.depths))
        std = 0.0
        if jitter is not None:
            std = float(np.hypot(np.mean(jitter.sigma_px), np.mean(jitter.sigma) * camera.fx / at))  # type: ignore[attr-defined]
        return {"add_kinect_azure_noise": float(with_noise < without), "add_gaussian_shifts_std_px": std}

    def moments(given: Parameters, depth: Floats) -> tuple[Floats, Floats]:
        sigma = AZURE_BASE + AZURE_SLOPE * np.maximum(depth - AZURE_FROM, 0)
        return np.zeros_like(depth), sigma * given["add_kinect_azure_noise"]

    def text(camera: Camera, given: Parameters, about: list[str]) -> str:
        rows = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
        lines = [*(f"# {line}" for line in about), "import blenderproc as bproc", "", f"K = {rows}", ""]
        lines += [f"bproc.camera.set_intrinsics_from_K_matrix(K, {camera.width}, {camera.height})"]
        lines += [
            "",
            "",
            "def sensed(data):",
            '    """Depth images of `bproc.renderer.render()`, as the sensor gives them."""',
        ]
        lines += ['    depth = data["depth"]']
        if given["add_gaussian_shifts_std_px"] > 0:
            std = given["add_gaussian_shifts_std_px"]
            lines += [f"    depth = bproc.postprocessing.add_gaussian_shifts(depth, std={std:.6g})"]
        if given["add_kinect_azure_noise"]:
            lines += ['    depth = bproc.postprocessing.add_kinect_azure_noise(depth, data["colors"])']
        return "\n".join([*lines, "    return depth", ""])

    return SimulatorTarget(
        "blenderproc",
        "z + n, n ~ N(0, 0.0005 + 0.001 max(z - 0.5, 0)) [m], or nothing; pixels jitter by N(0, std) [px]",
        "github DLR-RM/BlenderProc, postprocessing: add_kinect_azure_noise, add_gaussian_shifts",
        fit,
        moments,
        text,
        ("axial_noise", "lateral_noise", "amplitude_dropout"),
        "with its Azure noise: a jitter of 0.25 px more, and no depth on dark colours",
    )


def mujoco() -> SimulatorTarget:
    """MuJoCo's cameras make no errors but those of their depth buffer."""

    def fit(sensor: Sensor, camera: Camera, stated: StatedWall) -> Parameters:
        near, far = _limits(sensor)
        return {"znear": near, "zfar": far}

    def moments(given: Parameters, depth: Floats) -> tuple[Floats, Floats]:
        near, far = given["znear"], given["zfar"]
        # z = n f / (f - s (f - n)) of the buffer s in steps of 2^-24: even over a step
        step = depth**2 * (far - near) / (near * far) / 2**BUFFER_BITS
        return np.zeros_like(depth), step / np.sqrt(12)

    def text(camera: Camera, given: Parameters, about: list[str]) -> str:
        told = "\n".join(f"  {line}" for line in about).replace("--", "- -")
        centre = f"{camera.cx - (camera.width - 1) / 2:.9g} {(camera.height - 1) / 2 - camera.cy:.9g}"
        return (
            f'<!--\n{told}\n-->\n<mujoco>\n  <statistic extent="1"/>\n'
            f'  <visual><map znear="{given["znear"]:g}" zfar="{given["zfar"]:g}"/>'
            f'<global offwidth="{camera.width}" offheight="{camera.height}"/></visual>\n  <worldbody>\n'
            f'    <camera name="depth" resolution="{camera.width} {camera.height}"\n'
            f'            sensorsize="1 {camera.height / camera.width:.9g}"\n'
            f'            focalpixel="{camera.fx:.9g} {camera.fy:.9g}" principalpixel="{centre}"/>\n'
            "  </worldbody>\n</mujoco>\n"
        )

    return SimulatorTarget(
        "mujoco",
        "z = n f / (f - s (f - n)), s the depth buffer in steps of 2^-24: no errors of a sensor",
        "github google-deepmind/mujoco, python/mujoco/renderer.py; mujoco.readthedocs.io, camera, visual/map",
        fit,
        moments,
        text,
        ("focal_length", "principal_point"),
    )


TARGETS = {make().name: make for make in (isaac, mujoco, gazebo, blenderproc, habitat)}


def _limits(sensor: Sensor) -> tuple[float, float]:
    """Nearest and farthest depth [m] that a simulator renders: where the sensor gives values."""
    works = sensor.works
    return works.nearest or NEAR, works.farthest if np.isfinite(works.farthest) else FAR


def _below(x: Floats) -> Floats:
    """Share of a normal distribution below x [standard deviations]."""
    from scipy.special import ndtr

    return np.asarray(ndtr(x))
