"""A STEP file as solids with the names and colours of its assembly.

build123d's own import_step() replaces dots, blanks and brackets in names, and looks colours of faces up by the address of
objects that are already gone; so the document is walked here.
"""

from build123d import Color, Shape
from OCP.collections import Sequence_TDF_Label as Labels
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Quantity import Quantity_ColorRGBA
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from assembly import Part

COLOUR_KINDS = (XCAFDoc_ColorType.XCAFDoc_ColorGen, XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorCurv)

# What the kernel calls shapes that have no name.
NAMELESS = {"COMPOUND", "COMPSOLID", "SOLID", "SHELL", "FACE", "SHAPE"}


def read(path):
    """The solids of the file as a list of parts, and all of its shapes for the case that there are none."""
    document = TDocStd_Document(TCollection_ExtendedString("XCAF"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(True)
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.Transfer(document):
        return [], []
    free = Labels()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(free)
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    walk = Walk(colours)
    for label in items(free):
        walk.component(label, TopLoc_Location(), "", None)
    return walk.parts, walk.shapes


class Walk:
    """Depth first through the assembly."""

    def __init__(self, colours):
        self.colours = colours
        self.parts = []
        self.shapes = []

    def component(self, label, whole_from_parent, parent_name, parent_colour):
        product = referred(label)
        whole_from_own = whole_from_parent.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
        name = name_of(product) or parent_name
        colour = colour_of_label(label) or colour_of_label(product) or parent_colour
        if XCAFDoc_ShapeTool.IsAssembly_s(product):
            components = Labels()
            XCAFDoc_ShapeTool.GetComponents_s(product, components)
            for component in items(components):
                self.component(component, whole_from_own, name, colour)
        else:
            self.product(XCAFDoc_ShapeTool.GetShape_s(product), whole_from_own, name, colour)

    def product(self, topology, whole_from_own, name, colour):
        shape = Shape.cast(topology)
        self.shapes.append(shape)
        for solid in shape.solids():
            own = self.colour_of_shape(solid) or colour or self.colour_of_largest_face(solid)
            self.parts.append(Part(Shape.cast(solid.wrapped.Moved(whole_from_own)), name, own))

    def colour_of_shape(self, shape):
        colour = Quantity_ColorRGBA()
        found = any(self.colours.GetColor(shape.wrapped, kind, colour) for kind in COLOUR_KINDS)
        return channels(colour) if found else None

    def colour_of_largest_face(self, solid):
        coloured = [(face.area, self.colour_of_shape(face)) for face in solid.faces()]
        coloured = [(area, colour) for area, colour in coloured if colour]
        return max(coloured, key=lambda pair: pair[0])[1] if coloured else None


def referred(label):
    if not XCAFDoc_ShapeTool.IsReference_s(label):
        return label
    target = TDF_Label()
    XCAFDoc_ShapeTool.GetReferredShape_s(label, target)
    return target


def name_of(label):
    name = TDataStd_Name()
    if not label.FindAttribute(TDataStd_Name.GetID_s(), name):
        return ""
    text = TCollection_AsciiString(name.Get()).ToCString()
    text = "".join(character for character in text if character.isprintable()).strip()
    return "" if text in NAMELESS else text


def colour_of_label(label):
    colour = Quantity_ColorRGBA()
    found = any(XCAFDoc_ColorTool.GetColor_s(label, kind, colour) for kind in COLOUR_KINDS)
    return channels(colour) if found else None


def channels(colour):
    """sRGB as written in the file, and opacity."""
    return [round(float(channel), 6) for channel in tuple(Color(colour))]


def items(sequence):
    return [sequence.Value(number + 1) for number in range(sequence.Length())]
