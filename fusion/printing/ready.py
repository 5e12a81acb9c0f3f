"""A scan made ready to print, step by step, and what every step did to it."""

from dataclasses import dataclass, replace

from fusion.errors import MeshError
from fusion.mesh.comparison.surface_samples import face_areas
from fusion.mesh.mesh import Mesh
from fusion.printing.closing import close_holes
from fusion.printing.faults import THIN, Faults, faults_of
from fusion.printing.fewer import decimated, moved_by, smoothed
from fusion.progress import stage
from fusion.quantity import SMOOTH, TRIANGLES, WALL


@dataclass(frozen=True)
class PrintSettings:
    """What is done to a mesh.

    Attributes:
        watertight: close all holes, and stand it on z = 0.
        smooth: steps of smoothing; 0: none.
        triangles: at most so many; None: as they are.
        thin: walls thinner than this are told [m].
    """

    watertight: bool = True
    smooth: int = 0
    triangles: int | None = None
    thin: float = THIN

    def __post_init__(self) -> None:
        SMOOTH.check(self.smooth)
        TRIANGLES.check(self.triangles)
        WALL.check(self.thin)


@dataclass(frozen=True)
class Moved:
    """How far a step moved the surface [m]."""

    rms: float
    max: float


@dataclass(frozen=True)
class PrintFigures:
    """A printable mesh in numbers: see `Printable`."""

    area_m2: float
    closed_area_m2: float | None
    lifted_m: float | None
    smoothed_m: Moved | None
    decimated_m: Moved | None
    triangles: int
    faults: Faults | None


@dataclass(frozen=True)
class Printable:
    """A mesh, and what was done to it; lengths in metres, None where a step was not asked for.

    Attributes:
        mesh: z up; where it was closed with the scalar "closed", 1 at vertices that nobody saw.
        area, closed_area: of the whole surface, and of what was closed.
        smoothed, decimated: (root mean square, largest) distance that these steps moved the surface by.
        lifted: by how much it was moved up to stand on z = 0.
        faults: what a printer would stumble over; None where it was not closed.
    """

    mesh: Mesh
    area: float
    closed_area: float | None = None
    smoothed: tuple[float, float] | None = None
    decimated: tuple[float, float] | None = None
    lifted: float | None = None
    faults: Faults | None = None

    def figures(self) -> PrintFigures:
        """What JSON tells of it."""
        smoothed, decimated = (None if moved is None else Moved(*moved) for moved in (self.smoothed, self.decimated))
        steps = (self.lifted, smoothed, decimated)
        return PrintFigures(self.area, self.closed_area, *steps, len(self.mesh.faces), self.faults)

    def lines(self) -> list[str]:
        """For a terminal."""
        out = []
        if self.closed_area is not None:
            share = self.closed_area / max(self.area, 1e-12)
            out.append(f"closed: {1e4 * self.closed_area:.1f} of {1e4 * self.area:.1f} cm2 ({share:.1%}) nobody saw")
        for name in ("smoothed", "decimated"):
            moved = getattr(self, name)
            if moved is not None:
                out.append(f"{name}: moved by {1e3 * moved[0]:.3f} mm (rms), at most {1e3 * moved[1]:.2f} mm")
        if self.decimated is not None:
            out.append(f"triangles: {len(self.mesh.faces):,}")
        return out + ([] if self.faults is None else _fault_lines(self.faults))


def _fault_lines(found: Faults) -> list[str]:
    lines = []
    if found.thin_share > 0:
        thinnest = f"thinnest {1e3 * found.thinnest:.2f} mm"
        lines.append(f"thin walls: {found.thin_share:.1%} of the surface below {1e3 * found.thin:g} mm, {thinnest}")
    if found.crossing:
        lines.append(f"passes through itself: {found.crossing:,} triangles")
    word = {True: "solid: yes", False: "solid: NO", None: "solid: not checked"}[found.solid]
    return [*lines, f"{word}, {found.why}; {1e6 * found.volume:.1f} cm3"]


def print_ready(mesh: Mesh, settings: PrintSettings | None = None) -> Printable:
    """Close, smooth, thin out, stand up, and look for faults.

    Raises:
        MeshError: a mesh without triangles, or one of which no closed surface comes.

    >>> cup = fusion.read_mesh("ball.ply")
    >>> made = fusion.print_ready(cup, fusion.PrintSettings(triangles=500))
    >>> made.mesh.vertices[:, 2].min().round(6), made.mesh.to_trimesh().is_watertight
    (np.float64(0.0), True)
    """
    settings = settings or PrintSettings()
    if not len(mesh.faces):
        raise MeshError("a point cloud cannot be printed", found="no triangles", expected="a mesh")
    done = Printable(mesh, float(face_areas(mesh).sum()))
    if settings.watertight:
        with stage("closing"):
            closed = close_holes(mesh)
        done = Printable(closed.mesh, closed.area, closed.closed_area)
    with stage("shaping"):
        if settings.smooth:
            calm = smoothed(done.mesh, settings.smooth)
            done = replace(done, mesh=calm, smoothed=moved_by(done.mesh, calm))
        if settings.triangles is not None:
            less = decimated(done.mesh, settings.triangles)
            done = replace(done, mesh=less, decimated=moved_by(done.mesh, less))
    if not settings.watertight:
        return done
    lowest = float(done.mesh.vertices[:, 2].min())
    standing = replace(done.mesh, vertices=done.mesh.vertices - [0, 0, lowest])
    with stage("checking"):
        return replace(done, mesh=standing, lifted=-lowest, faults=faults_of(standing, settings.thin))
