"""Is this the size of an object, or were millimetres taken for metres or inches? Asked before tessellating: a metre too many
is a million triangles too many."""

from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib

from refusal import Refusal

# Millimetres that people mean where the file or script means one, or the other way round.
MIX_UPS = [(1000.0, "metres"), (25.4, "inches"), (10.0, "centimetres")]


def check_size(parts, unit, request):
    """Refuses what is implausibly small or large, and names the factors that would mend it."""
    smallest, largest = request["size_mm"]
    sides = [side * request["scale"] for side in size(parts)]
    if smallest <= max(sides) <= largest:
        return
    word = "small" if max(sides) < smallest else "large"
    declared = f"; its file declares {unit}s" if unit else ""
    message = f"the object measures {in_words(sides)} mm, implausibly {word}{declared}"
    raise Refusal("size", message, hint(sides, smallest, largest))


def size(parts):
    """Sides of the box around all parts, mm; at worst a little too large, for spline surfaces."""
    box = Bnd_Box()
    box.SetGap(0.0)
    for part in parts:
        BRepBndLib.Add_s(part.solid.wrapped, box, False)
    low, high = box.CornerMin(), box.CornerMax()
    return [high.X() - low.X(), high.Y() - low.Y(), high.Z() - low.Z()]


def hint(sides, smallest, largest):
    small = max(sides) < smallest
    texts = []
    for factor, name in MIX_UPS:
        scale = factor if small else 1.0 / factor
        if smallest <= max(sides) * scale <= largest:
            meant = f"if it was drawn in {name}" if small else f"if it was drawn in mm and read as {name}"
            texts.append(f"{meant}, set scale = {scale:.8g} (gives {in_words([side * scale for side in sides])} mm)")
    texts.append(f"if it really is so, widen size_mm = [{smallest:g}, {largest:g}]")
    return "; ".join(texts)


def in_words(sides):
    return " × ".join(f"{side:.0f}" if side >= 100.0 else f"{side:.3g}" for side in sides)
