"""Traces rays through straight and bent rods with Mitsuba and holds the law of light against them.

usage: check_optics.py RODS.json

The file holds {law: {c1_per_mm, c2_per_mm, c3_per_mm}, core: {radius_mm, index}, cladding_index, half_angle_deg, lengths_mm, radii_mm, rays}.
A rod is a core in an endless cladding, meshed with smooth normals; what is refracted out is lost in the black layer. Rays start
as an LED's beam in the rod's face, lose c1 per mm of their own path, and count where they reach the far face. Printed is, per radius,
the loss per mm between the shortest and the longest rod, as traced with a smooth wall, with a rough one, and by the law.

Asked: a straight smooth rod loses c1 per mm, to 2 %; losses fall as the radius grows, traced and by the law; with the rough wall the order
of the radii is the law's and the tightest bend costs several times the widest. Not asked: the law's own numbers, which are a fit to prints whose
layers scatter light in ways that no smooth rod has.
"""

import json
import math
import random
import sys

import mitsuba as mi

mi.set_variant("scalar_rgb")

SIDES = 64
STEP_MM = 0.1
BOUNCES = 400
# Width of the microfacets of the rough wall: about one degree.
ROUGH_ALPHA = 0.02


def axis(radius: float | None, length: float):
    """Places and tangents along the rod: up, then round towards +x."""
    count = max(2, math.ceil(length / STEP_MM))
    for k in range(count + 1):
        s = length * k / count
        if radius is None:
            yield (0.0, 0.0, s), (0.0, 0.0, 1.0)
        else:
            t = s / radius
            yield (radius * (1 - math.cos(t)), 0.0, radius * math.sin(t)), (math.sin(t), 0.0, math.cos(t))


def tube(radius: float | None, length: float, core: float, bsdf: dict):
    """The rod's wall as a mesh with the normals of the round tube."""
    rings = list(axis(radius, length))
    # Circumscribed, so that the mesh has the tube's own mean radius.
    out = core / math.sqrt(math.sin(2 * math.pi / SIDES) / (2 * math.pi / SIDES))
    places, normals, faces = [], [], []
    for (x, _, z), (tx, _, tz) in rings:
        for j in range(SIDES):
            a = 2 * math.pi * j / SIDES
            n = (math.cos(a) * tz, math.sin(a), -math.cos(a) * tx)
            normals += n
            places += (x + out * n[0], out * n[1], z + out * n[2])
    for k in range(len(rings) - 1):
        for j in range(SIDES):
            a, b = k * SIDES + j, k * SIDES + (j + 1) % SIDES
            faces += (a, b, a + SIDES, b, b + SIDES, a + SIDES)
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    mesh = mi.Mesh("rod", len(places) // 3, len(faces) // 3, has_vertex_normals=True, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = places
    parameters["vertex_normals"] = normals
    parameters["faces"] = faces
    parameters.update()
    return mi.load_dict({"type": "scene", "rod": mesh})


def beam(rng: random.Random, core: float, half_angle: float, index: float):
    """A ray in the rod's face: evenly over it, with cos^m in air, refracted into the core."""
    rho, phi = core * math.sqrt(rng.random()) * 0.999, 2 * math.pi * rng.random()
    order = math.log(0.5) / math.log(math.cos(half_angle))
    cosine = rng.random() ** (1 / (order + 1))
    sine = math.sqrt(1 - cosine * cosine) / index
    psi = 2 * math.pi * rng.random()
    direction = (sine * math.cos(psi), sine * math.sin(psi), math.sqrt(1 - sine * sine))
    return (rho * math.cos(phi), rho * math.sin(phi), 1e-3), direction


def way_to_end(origin, direction, radius: float | None, length: float) -> float:
    """How far the ray is from the plane of the far face, beyond which it has arrived."""
    *_, (place, tangent) = axis(radius, length)
    towards = sum(d * t for d, t in zip(direction, tangent))
    if towards <= 0:
        return math.inf
    return sum((p - o) * t for p, o, t in zip(place, origin, tangent)) / towards


def throughput(rod: dict, radius: float | None, length: float, bsdf: dict, seed: int) -> float:
    core = rod["core"]["radius_mm"]
    scene = tube(radius, length, core, bsdf)
    context = mi.BSDFContext()
    rng = random.Random(seed)
    arrived = 0.0
    for _ in range(rod["rays"]):
        origin, direction = beam(rng, core, math.radians(rod["half_angle_deg"]), rod["core"]["index"])
        path = 0.0
        for _ in range(BOUNCES):
            hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(*origin), mi.Vector3f(*direction)))
            left = way_to_end(origin, direction, radius, length)
            if 0 <= left <= hit.t:
                arrived += math.exp(-rod["law"]["c1_per_mm"] * (path + left))
                break
            if not hit.is_valid():
                break
            path += hit.t
            sample, weight = hit.bsdf().sample(context, hit, rng.random(), mi.Point2f(rng.random(), rng.random()))
            out = hit.to_world(sample.wo)
            if max(weight) == 0 or out @ hit.n * (hit.to_world(hit.wi) @ hit.n) <= 0:
                break
            spot = hit.p + out * 1e-5
            origin, direction = tuple(spot), tuple(out)
    return arrived / rod["rays"]


def loss_per_mm(rod: dict, radius: float | None, bsdf: dict, seed: int) -> float:
    short, long = min(rod["lengths_mm"]), max(rod["lengths_mm"])
    near, far = (throughput(rod, radius, length, bsdf, seed) for length in (short, long))
    return math.log(near / far) / (long - short) if far > 0 and near > 0 else math.inf


def main() -> int:
    rod = json.load(open(sys.argv[1], encoding="utf-8"))
    law, indices = rod["law"], {"int_ior": rod["core"]["index"], "ext_ior": rod["cladding_index"]}
    smooth = {"type": "dielectric", **indices}
    rough = {"type": "roughdielectric", "alpha": ROUGH_ALPHA, **indices}
    radii = sorted(rod["radii_mm"]) + [None]
    table = []
    for radius in radii:
        bend = 0.0 if radius is None else math.exp(-law["c3_per_mm"] * radius)
        table.append(
            (loss_per_mm(rod, radius, smooth, 1), loss_per_mm(rod, radius, rough, 1), law["c1_per_mm"] + law["c2_per_mm"] * bend)
        )
        name = "straight" if radius is None else f"{radius:g} mm"
        print(f"{name:>9}: smooth {table[-1][0]:.4f}, rough {table[-1][1]:.4f}, law {table[-1][2]:.4f} per mm", flush=True)
    complaints = []
    if abs(table[-1][0] / law["c1_per_mm"] - 1) > 0.02:
        complaints.append(f"a straight rod loses {table[-1][0]:.5f} per mm, not {law['c1_per_mm']}")
    noise = 4e-3
    for column, name in ((0, "smooth"), (1, "rough")):
        values = [row[column] for row in table]
        if any(after > before + noise for before, after in zip(values, values[1:])):
            complaints.append(f"with a {name} wall losses do not fall as the radius grows: {values}")
    if not table[0][1] > 2 * table[-1][1]:
        complaints.append(f"the tightest bend hardly costs more than none: {table[0]}, {table[-1]}")
    print("\n".join(complaints) or "the law's slope and trend hold")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
