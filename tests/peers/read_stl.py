"""Reads a binary STL with readers of other people and prints their seconds of processor time, the best of three, as JSON.

    read_stl.py FILE

Importing them is left out. The first two give triangles with corners of their own, the others a mesh of shared corners.
"""

import json
import sys
import time

import networkx  # noqa: F401  trimesh imports it when it first needs it
import numpy as np
import pymeshlab
import trimesh

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


def with_numpy(path):
    return np.fromfile(path, dtype=RECORD, offset=84)["corners"].astype(np.float64)


def with_trimesh_loose(path):
    return trimesh.load(path, process=False)


def with_trimesh(path):
    return trimesh.load(path)


def with_meshlab(path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    return meshes


def seconds(read, path):
    started = time.process_time()
    read(path)
    return time.process_time() - started


def main():
    readers = {
        "numpy, as records, no look at them": with_numpy,
        "trimesh, as loose triangles": with_trimesh_loose,
        "trimesh, equal corners shared": with_trimesh,
        "pymeshlab, equal corners shared": with_meshlab,
    }
    print(json.dumps({name: min(seconds(read, sys.argv[1]) for _ in range(3)) for name, read in readers.items()}))


main()
