"""What is said beside the distances: what they do not tell, and why."""

import numpy as np

from fusion.mesh.alignment.align import Alignment
from fusion.mesh.mesh import Mesh


def itself_note(mesh: Mesh, reference: Mesh) -> list[str]:
    """That both are one and the same, as where a file was named twice."""
    if not np.array_equal(mesh.vertices, reference.vertices):
        return []
    return ["Mesh and reference are the same, number by number: whatever is told of the distances says nothing."]


def freedom_note(alignment: Alignment) -> list[str]:
    """What the shapes leave free of the pose."""
    angles = sorted({round(float(np.rad2deg(angle))) for angle in alignment.turns})
    said = []
    if angles:
        turned = " or ".join(f"{angle}" for angle in angles) if len(angles) <= 3 else "any of many angles"
        said.append(f"turned by {turned}{' deg' if len(angles) <= 3 else ''}")
    if alignment.slides:
        said.append(f"slid by {1e3 * alignment.slides:.2g} mm or more along its own surface")
    if not said:
        return []
    return [
        f"{' or '.join(said).capitalize()} besides, the mesh fits the reference as well: "
        f"how large the distances are holds, but not where on the object; --no-align keeps a pose that is known."
    ]


def scale_note(alignment: Alignment) -> list[str]:
    """What one scale would explain that was not asked for."""
    asked = alignment.asks_scale
    if asked is None:
        return []
    other = "smaller" if asked > 1 else "larger"
    return [
        f"The mesh is {abs(1 / asked - 1):.2%} {other} than the reference all over: --scale fits that, and says how "
        f"sure it is; a wrong focal length, a wrong depth or a coat make scans so."
    ]
