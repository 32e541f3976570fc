"""STEP and BREP files. Their readers raise nothing on damaged input, so that every promise is checked here."""

import contextlib
import os
import re
import sys
import tempfile

from refusal import Refusal

SOLID_RECORDS = re.compile(rb"=\s*\(?\s*(?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS|FACETED_BREP)\s*\(")
TEXTS = re.compile(rb"'[^']*'|/\*.*?\*/", re.DOTALL)
RECORDS = re.compile(rb"(?:^|;)\s*#(\d+)\s*=", re.MULTILINE)
REFERENCES = re.compile(rb"#(\d+)")
METRES = re.compile(rb"SI_UNIT\s*\(\s*(\$|\.[A-Z]+\.)\s*,\s*\.METRE\.\s*\)")
NAMED_LENGTHS = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'(INCH|FOOT|FEET|MIL|YARD)\w*'", re.IGNORECASE)


def read_step(path, request):
    """The solids in the file, scaled to mm by the reader, and the unit that the file declares."""
    shown = request["shown"]
    data = path.read_bytes()
    check_step(data, shown)
    import step_assembly

    with reader_messages() as messages:
        try:
            parts, shapes = step_assembly.read(path)
        except Exception as error:
            raise Refusal("file", f"{shown}: the STEP reader failed: {error}")
    errors = [line.split("**** ERR", 1)[1].strip(" *") for line in messages if "**** ERR" in line]
    if errors:
        raise Refusal("file", f"{shown} is damaged: {errors[0]}", "export it again from the CAD program")
    check_solids(data, parts, shown)
    return parts or shapes, step_unit(data)


def check_step(data, shown):
    if b"ISO-10303-21" not in data[:4096]:
        raise Refusal("file", f"{shown} is no STEP file: it does not begin with ISO-10303-21")
    if b"END-ISO-10303-21" not in data[-4096:]:
        lines = data.count(b"\n") + 1
        hint = "copy or export it again"
        raise Refusal("file", f"{shown} is cut short: no END-ISO-10303-21 after {lines} lines", hint)
    records = TEXTS.sub(b"", data)
    lost = set(REFERENCES.findall(records)) - set(RECORDS.findall(records))
    if lost:
        number = min(lost, key=int).decode()
        raise Refusal("file", f"{shown} is damaged: {len(lost)} records are missing, #{number} first", "export it again")


def check_solids(data, parts, shown):
    """No solid may get lost in reading."""
    written = len(SOLID_RECORDS.findall(data))
    # Kept alive: an address identifies a shape only as long as nothing else can take its place.
    read = len(set([part.solid.wrapped.TShape() for part in parts]))
    if 0 < read < written:
        hint = "export it again, or only the parts you need"
        raise Refusal("file", f"{shown}: only {read} of its {written} solids can be read", hint)


def step_unit(data):
    """The unit of length a STEP file declares, in words; None if it cannot be told."""
    named = NAMED_LENGTHS.search(data)
    if named:
        return named.group(1).decode().lower()
    metres = {prefix.decode().strip(".$").lower() + "metre" for prefix in METRES.findall(data)}
    return metres.pop() if len(metres) == 1 else None


def read_brep(path, request):
    shown = request["shown"]
    if b"CASCADE Topology" not in path.read_bytes()[:4096]:
        raise Refusal("file", f"{shown} is no BREP file: its head does not say \"CASCADE Topology\"")
    from build123d import import_brep

    with reader_messages():
        try:
            return import_brep(path)
        except Exception as error:
            raise Refusal("file", f"{shown} is damaged or cut short: {' '.join(str(error).split())}", "export it again")


@contextlib.contextmanager
def reader_messages():
    """What C++ prints meanwhile, line by line, once the block has ended."""
    lines = []
    sys.stdout.flush()
    own = os.dup(1)
    with tempfile.TemporaryFile() as caught:
        os.dup2(caught.fileno(), 1)
        try:
            yield lines
        finally:
            os.dup2(own, 1)
            os.close(own)
            caught.seek(0)
            lines.extend(re.sub(r"\x1b\[[0-9;]*m", "", caught.read().decode(errors="replace")).splitlines())
