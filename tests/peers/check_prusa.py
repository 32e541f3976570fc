"""Slices the prusa profile with PrusaSlicer and weighs what each of the five tools extrudes.

usage: check_prusa.py OBJECT-PRUSA.3mf PRINTER.ini OBJECT.3mf

The solids' volumes come from OBJECT.3mf, read by lib3mf. PrusaSlicer draws a line of width w and height h with round
flanks, area h·(w − h·(1 − π/4)), and puts its outermost line w/2 from the wall; so every side wall lacks a layer of
h·(1 − π/4)/2 = 0.0215 mm at h = 0.2 mm, unless infill makes up for it. So a tool must extrude no more than the volume of
its solids, and no less than that without this layer on their area as seen from the side; either may be missed by 4 %.
The slicer's exit code says nothing: it is 0 with a single tool, too.
"""

import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import meshes_of_3mf

ROLES = ["core", "cladding", "black", "skin", "filler"]
TOLERANCE = 0.04


def setting(printer: str, key: str) -> str:
    return re.search(rf"^{key} *= *(.+)$", printer, re.MULTILINE)[1]


def slice_to_gcode(model: str, printer: str, gcode: Path) -> None:
    options = ["-g", "--load", printer, "--merge", "--dont-arrange", "-o", str(gcode), model]
    subprocess.run(["prusa-slicer", *options], check=True, stdout=subprocess.DEVNULL)


def extruded_mm(gcode: Path) -> dict[int, float]:
    """Filament that each tool lays down, mm; what is only pulled back and pushed again does not count."""
    laid, pulled_back = {}, {}
    tool, position = 0, 0.0
    word = re.compile(r"\bE(-?[0-9.]+)")
    for line in gcode.open():
        if change := re.match(r"T(\d+)", line):
            tool = int(change[1])
        elif line.startswith(("G1 ", "G92 ")) and (found := word.search(line.split(";")[0])):
            length = float(found[1]) - position if line.startswith("G1 ") else 0.0
            position = float(found[1])
            owed = pulled_back.get(tool, 0.0) - length
            pulled_back[tool] = max(owed, 0.0)
            if owed < 0.0:
                laid[tool] = laid.get(tool, 0.0) - owed
    return laid


def bounds_mm3(path: str, layer_mm: float) -> list[tuple[float, float]]:
    """Least and greatest volume that each tool should extrude."""
    lacking_mm = layer_mm * (1.0 - math.pi / 4.0) / 2.0
    least, greatest = [0.0] * len(ROLES), [0.0] * len(ROLES)
    for mesh in meshes_of_3mf.read(path)[0]:
        role = ROLES.index(mesh.name.split("-")[0])
        least[role] += mesh.volume_mm3 - lacking_mm * mesh.side_area_mm2
        greatest[role] += mesh.volume_mm3
    return list(zip(least, greatest))


def main() -> int:
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    model, printer_file, spec = sys.argv[1:]
    printer = Path(printer_file).read_text()
    filament_mm2 = math.pi / 4.0 * float(setting(printer, "filament_diameter").split(",")[0]) ** 2
    with tempfile.TemporaryDirectory() as folder:
        gcode = Path(folder) / "object.gcode"
        slice_to_gcode(model, printer_file, gcode)
        laid = extruded_mm(gcode)
    if sorted(laid) != list(range(len(ROLES))):
        print(f"{model}: sliced with tools {sorted(laid)} instead of {len(ROLES)}", file=sys.stderr)
        return 1
    wrong = 0
    for tool, (least, greatest) in enumerate(bounds_mm3(spec, float(setting(printer, "layer_height")))):
        extruded = laid[tool] * filament_mm2
        fits = least * (1.0 - TOLERANCE) <= extruded <= greatest * (1.0 + TOLERANCE)
        wrong += not fits
        shares = f"{extruded / least - 1.0:+.2%} / {extruded / greatest - 1.0:+.2%}"
        print(f"T{tool} {ROLES[tool]:<10}{extruded:>12.1f} mm³, bounds {least:.1f} to {greatest:.1f} ({shares})")
    if wrong:
        print(f"{model}: {wrong} tools extrude more than {TOLERANCE:.0%} too much or too little", file=sys.stderr)
    return 1 if wrong else 0


sys.exit(main())
