"""A cone with strong ripples: eight lobes around, rings up the side, a slight twist, a rounded top.

111 x 111 x 87 mm, base on z = 0. Of our own design, for the object of that name and size in Tone 2020; like it, it looks the
same from eight sides. A recipe may set every name below by `parameters = { ... }`. build123d 0.13.
"""

from math import cos, pi, radians, sin

from build123d import Face, Plane, Spline, Wire, fillet, loft

width_mm = 111.0       # across the crests of the lobes, at the base
height_mm = 87.0
top_width_mm = 34.0    # of the cone, at its top
lobes = 8              # a multiple of four, so that crests lie on both axes
lobe_mm = 5.5          # half the depth of a valley, at the base
rings = 3
ring_mm = 2.0          # half the depth of a ring
twist_deg = 22.5       # from base to top
top_rounding_mm = 6.0

POINTS_PER_LOBE = 6
SECTIONS_PER_RING = 5


def radius(angle, up):
    """Distance of the surface from the axis; `up` runs from 0 at the base to 1 at the top."""
    # Ripples fade towards the top; the side stands upright on the base and leans in above.
    lobe, ring = lobe_mm * (1.0 - up**2), ring_mm * (1.0 - up)
    base = width_mm / 2.0 - lobe_mm - ring_mm
    cone = base + (top_width_mm / 2.0 - base) * up**1.3
    return cone + lobe * cos(lobes * angle) + ring * cos(2.0 * pi * rings * up)


def section(up):
    """The outline at one height, a closed spline."""
    count = POINTS_PER_LOBE * lobes
    # The seam of the spline lies in a valley: it is not quite smooth.
    angles = [2.0 * pi * (k + POINTS_PER_LOBE // 2) / count for k in range(count)]
    turn = radians(twist_deg) * up
    points = [(radius(a, up) * cos(a + turn), radius(a, up) * sin(a + turn)) for a in angles]
    return Plane.XY.offset(height_mm * up) * Face(Wire(Spline(*points, periodic=True)))


def main():
    count = rings * SECTIONS_PER_RING
    cone = loft([section(k / count) for k in range(count + 1)])
    top = cone.faces().sort_by()[-1]
    return fillet(top.edges(), top_rounding_mm)


result = main()
result.label = "wavy cone"
