"""A town house: plinth, four storeys of windows between ledges, a door, and a roof that steps back twice.

87 x 152 x 101 mm, base on z = 0. Of our own design, for the object of that name and size in Tone 2020. A recipe may set every
name below by `parameters = { ... }`. build123d 0.13.
"""

from build123d import Align, Box, Color, Compound, Location, Part

depth_mm = 87.0         # along x, over the ledges
width_mm = 152.0        # along y
height_mm = 101.0
storeys = 4
storey_mm = 15.5
plinth_mm = 7.0
ledge_mm = 2.0          # height of a ledge
overhang_mm = 0.8       # of plinth and ledges before the wall
recess_mm = 2.0         # how deep windows and door lie behind the wall
window_mm = (8.0, 9.5)  # width, height
window_pitch_mm = 15.5
step_inset_mm = 14.0    # of each roof step, on every side

GROUND = (Align.CENTER, Align.CENTER, Align.MIN)


def slab(depth, width, bottom, top):
    """A block around the axis."""
    return Location((0, 0, bottom)) * Box(depth, width, top - bottom, align=GROUND)


def row_of(length):
    """Centres of as many windows as the length of a wall has room for."""
    count = int((length - 4.0) // window_pitch_mm)
    return [(k - (count - 1) / 2.0) * window_pitch_mm for k in range(count)]


def windows(depth, width, sill, height):
    """What is cut out of the four walls of a block for one storey."""
    across = window_mm[0]
    lift = Location((0, 0, sill))
    along_x = [Location((x, 0, 0)) * lift * Box(across, width + 1.0, height, align=GROUND) for x in row_of(depth)]
    along_y = [Location((0, y, 0)) * lift * Box(depth + 1.0, across, height, align=GROUND) for y in row_of(width)]
    core = slab(depth - 2.0 * recess_mm, width - 2.0 * recess_mm, sill - 1.0, sill + height + 1.0)
    return [Part() + (along_x + along_y) - core]


def storey(depth, width, bottom, top):
    """A block with a ledge along its top and windows below."""
    wall = slab(depth - 2.0 * overhang_mm, width - 2.0 * overhang_mm, bottom, top)
    height = min(window_mm[1], top - bottom - ledge_mm - 2.0)
    sill = bottom + (top - ledge_mm - bottom - height) / 2.0
    wall -= windows(depth - 2.0 * overhang_mm, width - 2.0 * overhang_mm, sill, height)
    return wall + slab(depth, width, top - ledge_mm, top)


def door():
    """Two leaves in the middle of the front, from the plinth upwards."""
    deep = 2.0 * (recess_mm + overhang_mm)
    return Location((depth_mm / 2.0, 0, plinth_mm / 2.0)) * Box(deep, 12.0, plinth_mm / 2.0 + 12.0, align=GROUND)


def main():
    eaves = plinth_mm + storeys * storey_mm
    house = slab(depth_mm, width_mm, 0.0, plinth_mm)
    for k in range(storeys):
        house += storey(depth_mm, width_mm, plinth_mm + k * storey_mm, plinth_mm + (k + 1) * storey_mm)
    house -= door()
    roof = Part()
    step = (height_mm - eaves) / 2.0
    for k in (1, 2):
        inset = 2.0 * k * step_inset_mm
        roof += storey(depth_mm - inset, width_mm - inset, eaves + (k - 1) * step, eaves + k * step)
    house.label, house.color = "house", Color(0.87, 0.80, 0.68)
    roof.label, roof.color = "roof", Color(0.55, 0.24, 0.18)
    return Compound(label="building", children=[house, roof])


result = main()
