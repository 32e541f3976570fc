"""What a script or file hands over, as a list of solids, each with the label and colour that it or its assembly has."""

from dataclasses import dataclass

from build123d import Location, Shape

from refusal import Refusal


@dataclass
class Part:
    """One solid in the frame of the whole."""

    solid: Shape
    label: str
    colour: list | None


def parts(result):
    """The solids of a shape, a builder, a list, or a dict of names, in their order."""
    found = list(parts_of(result, ""))
    if not found:
        instead = contents(result)
        message = f"there is no solid, only {instead}" if instead else "there is no solid, nor anything else"
        raise Refusal("no-solid", message, "close the shells, or give faces a thickness" if instead else None)
    return found


def parts_of(result, label):
    if isinstance(result, Part):
        yield result
    elif isinstance(result, dict):
        for name, value in result.items():
            yield from parts_of(value, str(name))
    elif isinstance(result, Shape):
        yield from parts_of_shape(result, label)
    elif hasattr(result, "part") and hasattr(result, "to_combine"):
        if result.part is not None:
            yield from parts_of_shape(result.part, label)
    elif isinstance(result, (list, tuple, set)):
        for value in result:
            yield from parts_of(value, label)


def parts_of_shape(shape, label):
    if shape.wrapped is None:
        return
    label = shape.label or label
    by_tree = list(parts_of_tree(shape, Location(), label, None))
    solids = shape.solids()
    if len(by_tree) == len(solids):
        yield from by_tree
    else:
        # A tree of names beside other solids: the solids are right.
        for solid in solids:
            yield Part(solid, label, colour(shape))


def parts_of_tree(shape, whole_from_parent, label, inherited):
    """Depth first. A child's location is relative to its assembly."""
    label = shape.label or label
    own = colour(shape) or inherited
    if shape.children:
        whole_from_shape = whole_from_parent * shape.location
        for child in shape.children:
            yield from parts_of_tree(child, whole_from_shape, label, own)
    else:
        for solid in shape.solids():
            yield Part(move(solid, whole_from_parent), label, own)


def move(solid, whole_from_parent):
    return Shape.cast(solid.wrapped.Moved(whole_from_parent.wrapped))


def colour(shape):
    """Red, green, blue, opacity from 0 to 1, as build123d gives them (sRGB)."""
    return [round(float(channel), 6) for channel in tuple(shape.color)] if shape.color is not None else None


def contents(result):
    """What there is instead of solids, in words."""
    if isinstance(result, (list, tuple)):
        return "; ".join(contents(item) for item in result[:3])
    if not isinstance(result, Shape):
        result = getattr(result, "sketch", None) or getattr(result, "line", None) or result
    if not isinstance(result, Shape) or result.wrapped is None:
        return f"{type(result).__name__}"
    counts = [(len(result.shells()), "shell"), (len(result.faces()), "face"), (len(result.edges()), "edge")]
    texts = [f"{count} {what}{'s' * (count > 1)}" for count, what in counts if count]
    return " and ".join(texts)
