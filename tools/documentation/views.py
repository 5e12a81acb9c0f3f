"""A mesh as a picture of the tutorial: from four sides in its own colours, or in those of a number at each vertex.

python -m tools.documentation.views MESH OUT.svg [--scalar NAME --low MM --high MM --words TEXT]
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import fusion
from fusion.mesh.drawing.sight import sides
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import DIVERGING, SEQUENTIAL
from fusion.report.kit.views import Scale, ViewRow, mesh_views, scale_colors

UP, FRONT, SHOWN = np.array([0.0, 0.0, 1.0]), np.array([0.9, 0.45, 0.0]), 4


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path, metavar="MESH")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--scalar", help="of the mesh, in metres")
    parser.add_argument("--low", type=float, default=0.0, metavar="MM")
    parser.add_argument("--high", type=float, default=1.0, metavar="MM")
    parser.add_argument("--words", default="", metavar="TEXT", help="below the scale")
    said = parser.parse_args(arguments)
    mesh = fusion.read_mesh(said.mesh)
    scale = None
    colors = None if mesh.colors is None else mesh.colors / 255
    if said.scalar:
        scale = Scale(DIVERGING if said.low < 0 else SEQUENTIAL, said.low, said.high, said.words)
        colors = scale_colors(1e3 * mesh.scalars[said.scalar], scale)
    figure = mesh_views([ViewRow(mesh, colors)], sides(UP, FRONT)[:SHOWN], Figure("", "views", ""), scale)
    said.out.write_text(figure.svg, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
