"""An hourglass: a foot and a head, and between them a neck that every fibre of the head has to pass.

90 x 90 x 120 mm, base on z = 0. Of our own design: the paper's method does not route such shapes. A recipe may set every name
below by `parameters = { ... }`. build123d 0.13.
"""

from build123d import Align, Axis, Line, Plane, Spline, Wire, fillet, make_face, revolve

foot_width_mm = 90.0
head_width_mm = 80.0
height_mm = 120.0
neck_mm = 15.0         # its narrowest diameter, half-way up
rounding_mm = 4.0      # of the rims

foot, head, neck = foot_width_mm / 2.0, head_width_mm / 2.0, neck_mm / 2.0
waist = height_mm / 2.0
side = Spline(
    (foot, 14.0),
    (neck, waist),
    (head, height_mm - 14.0),
    tangents=[(0.0, 1.0), (0.0, 1.0), (0.0, 1.0)],
)
outline = Wire([
    Line((0.0, 0.0), (foot, 0.0)).edge(),
    Line((foot, 0.0), (foot, 14.0)).edge(),
    side.edge(),
    Line((head, height_mm - 14.0), (head, height_mm)).edge(),
    Line((head, height_mm), (0.0, height_mm)).edge(),
    Line((0.0, height_mm), (0.0, 0.0)).edge(),
])
profile = Plane.XZ * make_face(outline)
result = revolve(profile, Axis.Z)
rims = result.edges().group_by(Axis.Z)[-1]
result = fillet(rims, rounding_mm)
