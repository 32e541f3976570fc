"""The objects of a 3MF file as build123d's Mesher reads them: name, tab, volume in mm³, one a line.

usage: read_by_mesher.py FILE.3mf
"""

import sys

from build123d import Mesher

if len(sys.argv) != 2:
    sys.exit(__doc__)
for shape in Mesher().read(sys.argv[1]):
    print(f"{shape.label}\t{shape.volume!r}")
