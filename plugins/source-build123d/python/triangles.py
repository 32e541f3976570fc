"""A solid as triangles, face by face."""

from build123d import Shape
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_Transform
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.gp import gp_Trsf
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from refusal import Refusal

# Beside a sphere's poles the kernel was seen to miss its aim by up to 2.08 times, so it is told to aim at half.
AIM = 0.48
IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def of_solid(solid, label, request):
    """Coordinates, three per vertex, and indices, three per triangle. Vertices of neighbouring faces are apart but equal."""
    placed = fresh(solid.wrapped, request["scale"], request["turn"])
    # Not Shape.tessellate(): it takes the tolerance relative to the length of each edge, and keeps older triangles.
    relative, parallel = False, request["threads"] > 1
    BRepMesh_IncrementalMesh(placed, AIM * request["chord_error_mm"], relative, request["angle_rad"], parallel)
    coordinates, indices = [], []
    for number, face in enumerate(Shape.cast(placed).faces()):
        if not add_face(face.wrapped, coordinates, indices):
            name = f" of `{label}`" if label else ""
            message = f"face {number}{name} cannot be tessellated ({face.geom_type.name.lower()} near {face.center()})"
            raise Refusal("file", message, "check the shape in the CAD program; another chord_error_mm may help")
    return coordinates, indices


def fresh(shape, scale, turn):
    """A copy without triangles (they are kept with a shape, whatever their tolerance was), turned and scaled."""
    if scale == 1.0 and turn == IDENTITY:
        return BRepBuilderAPI_Copy(shape, True, False).Shape()
    transform = gp_Trsf()
    transform.SetValues(*(scale * value for row in turn for value in (*row, 0.0)))
    return BRepBuilderAPI_Transform(shape, transform, True, False).Shape()


def add_face(face, coordinates, indices):
    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, location)
    if mesh is None:
        return False
    whole_from_face = location.Transformation()
    first = len(coordinates) // 3 - 1
    for number in range(1, mesh.NbNodes() + 1):
        point = mesh.Node(number).Transformed(whole_from_face)
        coordinates.extend((point.X(), point.Y(), point.Z()))
    inward = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    order = (1, 3, 2) if inward else (1, 2, 3)
    for number in range(1, mesh.NbTriangles() + 1):
        triangle = mesh.Triangle(number)
        indices.extend(first + triangle.Value(corner) for corner in order)
    return True
