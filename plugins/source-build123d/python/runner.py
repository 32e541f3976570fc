"""Shape in, triangles out: runs a build123d script, or reads STEP or BREP, in a process of its own.

    python runner.py SOURCE OUT REQUEST.json

REQUEST.json: {"shown": name of SOURCE in messages, "parameters": {NAME: value}, "chord_error_mm", "angle_rad", "scale",
"turn": rows of a rotation, "size_mm": plausible least and greatest of the longest side, "threads"}. In the folder OUT appear

    manifest.json   {"solids": {"parts": [{label, colour, vertices, triangles}], "unit"}} or {"refused": {kind, message, ..}}
    vertices.f64    x, y, z of every vertex in mm, part after part, face after face: not welded
    triangles.u32   three indices into the part's own vertices, counter-clockwise from outside

Exit codes: 0 done, 3 the script or file is at fault, 4 there is no solid, 5 the environment is broken. No manifest means that
the process died. Nothing here knows fibar; welding and checking are done by those who read the buffers.
"""

import faulthandler
import json
import os
import signal
import sys
import traceback
from array import array
from pathlib import Path

FILES = {".py": "script", ".step": "step", ".stp": "step", ".brep": "brep", ".brp": "brep"}
EXIT_CODES = {"script": 3, "parameter": 3, "file": 3, "size": 3, "no-solid": 4, "environment": 5}


def main(source, out, request):
    from refusal import Refusal

    tell_where_it_died(out)
    try:
        try:
            manifest = {"solids": shape_to_buffers(source, out, request)}
            code = 0
        except ImportError as error:
            raise Refusal("environment", f"the environment is broken: {error}")
        except (RuntimeError, ValueError, TypeError, MemoryError) as error:
            traceback.print_exc()
            raise Refusal("file", f"{request['shown']}: the CAD kernel failed: {type(error).__name__}: {error}")
    except Refusal as refusal:
        manifest = {"refused": refusal.to_json()}
        code = EXIT_CODES[refusal.kind]
    # Under another name first: a manifest is whole or absent.
    (out / "manifest.tmp").write_text(json.dumps(manifest))
    os.replace(out / "manifest.tmp", out / "manifest.json")
    return code


def shape_to_buffers(source, out, request):
    shape, unit = load(source, request)
    import assembly
    import plausible
    import triangles

    parts = assembly.parts(shape)
    plausible.check_size(parts, unit, request)
    entries = []
    with open(out / "vertices.f64", "wb") as vertex_file, open(out / "triangles.u32", "wb") as triangle_file:
        for part in parts:
            coordinates, indices = triangles.of_solid(part.solid, part.label, request)
            array("d", coordinates).tofile(vertex_file)
            array("I", indices).tofile(triangle_file)
            counts = {"vertices": len(coordinates) // 3, "triangles": len(indices) // 3}
            entries.append({"label": part.label, "colour": part.colour, **counts})
    return {"parts": entries, "unit": unit}


def load(source, request):
    """The shape, and the unit its file declares."""
    kind = FILES[source.suffix.lower()]
    if kind == "script":
        import script_file

        return script_file.run(source, request), None
    import exchange_file

    return exchange_file.read_step(source, request) if kind == "step" else (exchange_file.read_brep(source, request), None)


def tell_where_it_died(out):
    """A crash, or SIGUSR1 from a host that lost its patience, leaves the running line in fault.txt."""
    # Kept open as long as the process lives.
    tell_where_it_died.file = open(out / "fault.txt", "w")
    faulthandler.enable(tell_where_it_died.file, all_threads=False)
    if hasattr(signal, "SIGUSR1"):
        faulthandler.register(signal.SIGUSR1, tell_where_it_died.file, all_threads=False)
    die_with_parent()


def die_with_parent():
    if sys.platform == "linux":
        import ctypes

        set_death_signal = 1
        ctypes.CDLL(None).prctl(set_death_signal, signal.SIGKILL)


if __name__ == "__main__":
    here = str(Path(__file__).resolve().parent)
    # Only for the modules beside this file; -P keeps the folder out of the path of the user's script otherwise.
    sys.path.append(here)
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), json.loads(Path(sys.argv[3]).read_text())))
