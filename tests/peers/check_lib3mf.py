"""Reads a 3MF file with lib3mf in strict mode: no warning, sound meshes with materials, one thing to build.

usage: check_lib3mf.py FILE.3mf
"""

import sys

from lib3mf import ModelUnit

import meshes_of_3mf


def complaints(meshes, warnings, model) -> list[str]:
    found = [f"warning: {warning}" for warning in warnings]
    found += [f"{mesh.name} is not closed and oriented" for mesh in meshes if not mesh.sound]
    found += [f"{mesh.name} encloses {mesh.volume_mm3} mm³" for mesh in meshes if mesh.volume_mm3 <= 0.0]
    if model.GetUnit() != ModelUnit.MilliMeter:
        found.append(f"the unit is {model.GetUnit()}, not millimetres")
    if model.GetBaseMaterialGroups().Count() != 1:
        found.append("there is not exactly one group of base materials")
    if model.GetBuildItems().Count() != 1:
        found.append(f"{model.GetBuildItems().Count()} things to build instead of one")
    return found


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    meshes, warnings, model = meshes_of_3mf.read(sys.argv[1])
    for mesh in meshes:
        print(f"{mesh.name:<20}{mesh.triangles:>9} triangles {mesh.volume_mm3:>14.3f} mm³")
    found = complaints(meshes, warnings, model)
    for complaint in found:
        print(f"{sys.argv[1]}: {complaint}", file=sys.stderr)
    return 1 if found else 0


sys.exit(main())
