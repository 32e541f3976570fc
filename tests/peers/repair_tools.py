"""Repairs every FOLDER/*.stl with the tools of other people and with a program of ours, one after the other on the same file.

    repair_tools.py FOLDER PROGRAM_OF_OURS

Leaves FOLDER/NAME.TOOL.ply (double coordinates, indexed) and FOLDER/repaired.json: by name and tool, `seconds` of processor time
or `refused` with the reason, and what the tool reports. Seconds are user + system time from reading the file to having written
the result: of a process of its own, less what the same program takes for a box of twelve triangles (its start), or within
Python, where importing the tool is left out.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import manifold3d
import networkx  # noqa: F401  trimesh imports it when it first needs it
import numpy as np
import pymeshfix
import scipy.sparse.csgraph  # noqa: F401
import scipy.spatial  # noqa: F401
import trimesh

LIMIT_S = 30
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
FACE = np.dtype([("count", "u1"), ("corners", "<u4", 3)])


class Refused(Exception):
    """The tool's own word that it cannot."""


def read_soup(path):
    """Corners of a binary STL."""
    return np.fromfile(path, dtype=RECORD, offset=84)["corners"]


def welded(soup):
    """Vertices and faces of a soup; only corners at the very same place become one. (By a hash of 64 bits: sorting places is slow.)"""
    places = np.ascontiguousarray(soup.reshape(-1, 3)) + np.float32(0.0)
    bits = places.view(np.uint32).astype(np.uint64)
    key = bits[:, 0] * np.uint64(0x9E3779B97F4A7C15)
    for axis, odd in ((1, 0xC2B2AE3D27D4EB4F), (2, 0x165667B19E3779F9)):
        key = (key ^ (key >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9) + bits[:, axis] * np.uint64(odd)
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    return places[first].astype(np.float64), number.reshape(-1, 3)


def write_mesh(path, vertices, faces):
    """The exchange form of fibar: `fibar.mesh/1`."""
    records = np.zeros(len(faces), dtype=FACE)
    records["count"], records["corners"] = 3, faces
    head = (
        "ply\nformat binary_little_endian 1.0\ncomment fibar.mesh/1, mm\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(head.encode() + np.ascontiguousarray(vertices, dtype="<f8").tobytes() + records.tobytes())


def with_meshfix(source, target, **options):
    vertices, faces = welded(read_soup(source))
    fixer = pymeshfix.MeshFix(vertices, faces.astype(np.int32), verbose=False)
    fixer.repair(**options)
    if len(fixer.faces) == 0:
        raise Refused("nothing is left")
    write_mesh(target, fixer.points, fixer.faces)


def with_meshfix_all(source, target):
    with_meshfix(source, target, remove_smallest_components=False)


def with_trimesh(source, target):
    mesh = trimesh.load(source, file_type="stl", process=False)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    mesh.update_faces(mesh.unique_faces())
    trimesh.repair.fill_holes(mesh)
    trimesh.repair.fix_normals(mesh, multibody=True)
    write_mesh(target, mesh.vertices, mesh.faces)


def with_manifold(source, target):
    vertices, faces = welded(read_soup(source))
    mesh = manifold3d.Mesh64(vertices, faces.astype(np.uint64))
    mesh.merge()
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError:
        raise Refused(solid.status().name)
    out = solid.to_mesh64()
    write_mesh(target, out.vert_properties[:, :3], out.tri_verts)


def limit():
    """Ends this process by a signal when it has taken too much processor time."""
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S + 1))


TOO_LONG = {"refused": f"not ready after {LIMIT_S} s"}


def fork(work):
    """Processor time of a piece of work in a child of its own, or its refusal."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        limit()
        started = time.process_time()
        try:
            work()
            said = {"seconds": time.process_time() - started}
        except Exception as error:  # whatever a tool raises is its answer
            said = {"refused": f"{type(error).__name__}: {error}" if not isinstance(error, Refused) else str(error)}
        os.write(writer, json.dumps(said).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    if said:
        return json.loads(said)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL):
        return TOO_LONG
    return {"refused": "crashed"}


def spend(command):
    """Output and processor time of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ran = subprocess.run(command, capture_output=True, text=True, errors="replace", preexec_fn=limit)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return ran, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def with_admesh(source, target):
    out = target.with_suffix(".stl")
    ran, seconds = spend(["admesh", f"--write-binary-stl={out}", str(source)])
    if -ran.returncode in (signal.SIGXCPU, signal.SIGKILL):
        return TOO_LONG
    if ran.returncode != 0 or not out.exists():
        return {"refused": "crashed"}
    soup = read_soup(out)
    if not np.isfinite(soup).all():
        return {"refused": "coordinates that are not numbers"}
    vertices, faces = welded(soup)
    apart = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    write_mesh(target, vertices, faces[apart])
    return {"seconds": seconds}


def ours(program):
    """`repair-manifold` with its own defaults, by a request of its own; it reads the same triangles in the form stages exchange."""

    def run(source, target):
        folder = target.parent / f"{target.stem}.out"
        folder.mkdir(exist_ok=True)
        request = {"params": {}, "inputs": {"mesh": [{"path": str(source.with_suffix(".ply"))}]}, "out_dir": str(folder)}
        (folder / "request.json").write_text(json.dumps(request))
        ran, seconds = spend([program, "--request", str(folder / "request.json")])
        if -ran.returncode in (signal.SIGXCPU, signal.SIGKILL):
            return TOO_LONG
        said = [json.loads(line) for line in ran.stdout.splitlines()]
        figures = {line["name"]: line["value"] for line in said if line["type"] == "metric"}
        wrong = [line for line in said if line["type"] == "error"]
        if wrong or not (folder / "body.ply").exists():
            return {"refused": wrong[0]["message"] if wrong else "crashed", "metrics": figures}
        (folder / "body.ply").rename(target)
        return {"seconds": seconds, "metrics": figures}

    return run


def in_child(tool):
    return lambda source, target: fork(lambda: tool(source, target))


def main():
    folder, program = Path(sys.argv[1]), sys.argv[2]
    tools = {
        "repair-manifold": ours(program),
        "pymeshfix": in_child(with_meshfix_all),
        "pymeshfix-largest": in_child(with_meshfix),
        "admesh": with_admesh,
        "trimesh": in_child(with_trimesh),
        "manifold": in_child(with_manifold),
    }
    sources = sorted(path for path in folder.glob("*.stl"))
    starts = {}
    box = folder / "start"
    box.mkdir()
    trimesh.creation.box((10, 10, 10)).export(box / "box.stl")
    write_mesh(box / "box.ply", *welded(read_soup(box / "box.stl")))
    for tool in ("repair-manifold", "admesh"):
        starts[tool] = min(tools[tool](box / "box.stl", box / f"{tool}-{k}.ply").get("seconds", 0.0) for k in range(9))
    results = {"starts": starts}
    for source in sources:
        results[source.stem] = {}
        for name, run in tools.items():
            said = run(source, folder / f"{source.stem}.{name}.ply")
            if "seconds" in said:
                said["seconds"] = max(said["seconds"] - starts.get(name, 0.0), 0.0)
            results[source.stem][name] = said
    (folder / "repaired.json").write_text(json.dumps(results, indent=1))


main()
