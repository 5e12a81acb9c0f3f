"""A sensor model for another simulator: its file, and the table of what is lost."""

from dataclasses import dataclass

from fusion import __version__
from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.loss import Loss, loss_of, stated
from fusion.simulation.exporting.target import Parameters, SimulatorTarget
from fusion.simulation.exporting.targets import TARGETS


@dataclass(frozen=True)
class Export:
    """A model on its way to another simulator.

    Attributes:
        target: the other simulator.
        parameters: of its law, the nearest to the own model.
        text: content of its file, which begins with where it comes from and what is lost.
        loss: the table.
    """

    target: SimulatorTarget
    parameters: Parameters
    text: str
    loss: Loss

    def __repr__(self) -> str:
        given = ", ".join(f"{name} {value:.4g}" for name, value in self.parameters.items())
        return f"<Export to {self.target.name}: {given}; {len(self.loss.lost)} effects lost>"


def export_sensor(sensor: Sensor, name: str, camera: Camera) -> Export:
    """The model in the parameters that another simulator understands.

    Args:
        sensor: the model.
        name: "isaac", "mujoco", "gazebo", "blenderproc" or "habitat".
        camera: its intrinsics; they are exported too.

    Raises:
        SensorError: no such simulator.

    >>> made = fusion.export_sensor(fusion.read_sensor("realsense-d435"), "isaac", fusion.find_camera("primesense"))
    >>> f"{made.parameters['noiseSigma']:.2f} px"
    '0.08 px'
    """
    if name not in TARGETS:
        raise SensorError("there is no export to this simulator", "--to", name, ", ".join(TARGETS))
    target = TARGETS[name]()
    parameters = target.fit(sensor, camera, stated(sensor, camera))
    loss = loss_of(sensor, camera, target, parameters)
    about = [f"{sensor.name}, exported by fusion {__version__}", f"law: {target.formula}", *table(loss)]
    about += [f"lost: {', '.join(loss.lost)}"] if loss.lost else []
    about += [f"besides, this simulator makes {target.own}"] if target.own else []
    return Export(target, parameters, target.text(camera, parameters, about), loss)


def table(loss: Loss) -> list[str]:
    """The lines of what is lost, in millimetres."""
    lines = [f"{'depth':>6} {'mean error [mm]':>17} {'spread [mm]':>15} {'rms [mm]':>9} {'without':>8}"]
    lines += [f"{'[m]':>6} {'own':>8} {'exported':>8} {'own':>6} {'exported':>8} {'apart':>9} {'export':>8}"]
    for row, depth in enumerate(loss.depths):
        own, other = 1e3 * loss.own[row], 1e3 * loss.exported[row]
        apart, whole = 1e3 * loss.rms[row], 1e3 * loss.whole[row]
        cells = f"{own[0]:>8.2f} {other[0]:>8.2f} {own[1]:>6.2f} {other[1]:>8.2f} {apart:>9.2f} {whole:>8.2f}"
        lines.append(f"{depth:>6.2f} {cells}")
    return lines
