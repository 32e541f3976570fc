"""A house of two labelled parts as a STEP file, written by build123d.

usage: labelled_house.py OUT.step
"""

import sys

from build123d import Align, Box, Color, Compound, Location, export_step

GROUND = (Align.CENTER, Align.CENTER, Align.MIN)

if len(sys.argv) != 2:
    sys.exit(__doc__)
tower = Box(48, 44, 34, align=GROUND)
roof = Location((0, 0, 34)) * Box(40, 36, 12, align=GROUND)
tower.label, tower.color = "tower & walls", Color(0.8, 0.7, 0.5)
roof.label, roof.color = "roof", Color(0.6, 0.2, 0.1)
export_step(Compound(label="house", children=[tower, roof]), sys.argv[1])
