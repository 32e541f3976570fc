"""The mesh objects of a 3MF file as the 3MF Consortium's lib3mf reads them, strictly."""

from dataclasses import dataclass
from math import hypot

import lib3mf


@dataclass
class Mesh:
    """A mesh object and what can be summed over its triangles."""

    name: str
    triangles: int
    sound: bool
    """Closed, oriented, every edge on two triangles."""
    volume_mm3: float
    side_area_mm2: float
    """Area as seen from the side: every triangle's area times the sine of its normal's angle to +Z."""


def read(path: str) -> tuple[list[Mesh], list[str], lib3mf.Model]:
    """Meshes, warnings and the whole model; raises where the strict reader gives up."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(path)
    warnings = [str(reader.GetWarning(k)) for k in range(reader.GetWarningCount())]
    return [_measure(mesh) for mesh in _each(model.GetMeshObjects(), "GetCurrentMeshObject")], warnings, model


def _each(iterator, current: str):
    while iterator.MoveNext():
        yield getattr(iterator, current)()


def _measure(mesh) -> Mesh:
    points = [tuple(vertex.Coordinates) for vertex in mesh.GetVertices()]
    volume = side_area = 0.0
    for triangle in mesh.GetTriangleIndices():
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[k] for k in triangle.Indices)
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        volume += (ax * nx + ay * ny + az * nz) / 6.0
        side_area += hypot(nx, ny) / 2.0
    sound = mesh.IsManifoldAndOriented() and mesh.IsValid()
    return Mesh(mesh.GetName(), mesh.GetTriangleCount(), sound, volume, side_area)
