//! Subdivision as the papers print it, step by step, to hold OpenSubdiv against. Slow and plain on purpose.
//!
//! Loop 1987 (§3), with creases of Hoppe et al. 1994 (table 1); Catmull & Clark 1978, with those of DeRose, Kass, Truong 1998 (§2).

use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Polygons with sharp edges and corners; rims are sharp.
#[derive(Clone, Default)]
pub struct Cage {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<Vec<usize>>,
    pub creases: BTreeSet<[usize; 2]>,
    pub corners: BTreeSet<usize>,
}

/// Faces on each edge, in order of the edges.
type Edges = BTreeMap<[usize; 2], Vec<usize>>;

fn key(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

fn sides(face: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()]))
}

impl Cage {
    pub fn edges(&self) -> Edges {
        let mut edges = Edges::new();
        for (f, face) in self.faces.iter().enumerate() {
            sides(face).for_each(|(a, b)| edges.entry(key(a, b)).or_default().push(f));
        }
        edges
    }

    fn is_sharp(&self, edge: &[usize; 2], faces: &[usize]) -> bool {
        faces.len() != 2 || self.creases.contains(edge)
    }

    fn mean(&self, of: &[usize]) -> DVec3 {
        of.iter().map(|&v| self.vertices[v]).sum::<DVec3>() / of.len() as f64
    }

    /// Where sharp edges put a vertex; `None` where it is smooth or a dart.
    fn held(&self, v: usize, edges: &Edges) -> Option<DVec3> {
        let sharp = edges.iter().filter(|(edge, faces)| edge.contains(&v) && self.is_sharp(edge, faces));
        let others: Vec<usize> = sharp.map(|([a, b], _)| a + b - v).collect();
        match others[..] {
            _ if self.corners.contains(&v) => Some(self.vertices[v]),
            [] | [_] => None,
            [a, b] => Some(0.75 * self.vertices[v] + 0.125 * (self.vertices[a] + self.vertices[b])),
            _ => Some(self.vertices[v]),
        }
    }

    fn neighbours(&self, v: usize, edges: &Edges) -> Vec<usize> {
        edges.keys().filter(|edge| edge.contains(&v)).map(|[a, b]| a + b - v).collect()
    }

    /// Both halves of each crease, and the corners; `middle` is where an edge's new vertex is.
    fn inherit(&self, next: &mut Cage, middle: &BTreeMap<[usize; 2], usize>) {
        for edge in &self.creases {
            next.creases.extend(edge.map(|end| key(end, middle[edge])));
        }
        next.corners.clone_from(&self.corners);
    }
}

/// One step of Loop's scheme.
pub fn loop_step(cage: &Cage) -> Cage {
    let edges = cage.edges();
    let moved = |v: usize| {
        let around = cage.neighbours(v, &edges);
        let n = around.len() as f64;
        let beta = (0.625 - (0.375 + 0.25 * (TAU / n).cos()).powi(2)) / n;
        (1.0 - n * beta) * cage.vertices[v] + beta * n * cage.mean(&around)
    };
    let vertices = (0..cage.vertices.len()).map(|v| cage.held(v, &edges).unwrap_or_else(|| moved(v)));
    let mut next = Cage { vertices: vertices.collect(), ..Cage::default() };
    let mut middle = BTreeMap::new();
    for (edge, faces) in &edges {
        middle.insert(*edge, next.vertices.len());
        let ends = cage.mean(edge);
        let opposite = |f: &usize| *cage.faces[*f].iter().find(|v| !edge.contains(v)).unwrap();
        let apart: Vec<usize> = faces.iter().map(opposite).collect();
        next.vertices.push(if cage.is_sharp(edge, faces) {
            ends
        } else {
            0.75 * ends + 0.25 * cage.mean(&apart)
        });
    }
    for face in &cage.faces {
        let [a, b, c] = face[..] else { panic!("Loop wants triangles") };
        let [ab, bc, ca] = [key(a, b), key(b, c), key(c, a)].map(|edge| middle[&edge]);
        next.faces.extend([vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]]);
    }
    cage.inherit(&mut next, &middle);
    next
}

/// One step of Catmull and Clark's scheme.
pub fn catmull_clark_step(cage: &Cage) -> Cage {
    let edges = cage.edges();
    let centres: Vec<DVec3> = cage.faces.iter().map(|face| cage.mean(face)).collect();
    let mean = |of: &[usize]| of.iter().map(|&f| centres[f]).sum::<DVec3>() / of.len() as f64;
    let moved = |v: usize| {
        let around = cage.neighbours(v, &edges);
        let faces: Vec<usize> = (0..cage.faces.len()).filter(|&f| cage.faces[f].contains(&v)).collect();
        let (n, here) = (around.len() as f64, cage.vertices[v]);
        let middles = 0.5 * (here + cage.mean(&around));
        (mean(&faces) + 2.0 * middles + (n - 3.0) * here) / n
    };
    let vertices = (0..cage.vertices.len()).map(|v| cage.held(v, &edges).unwrap_or_else(|| moved(v)));
    let mut next = Cage { vertices: vertices.collect(), ..Cage::default() };
    let mut middle = BTreeMap::new();
    for (edge, faces) in &edges {
        middle.insert(*edge, next.vertices.len());
        let ends = cage.mean(edge);
        next.vertices.push(if cage.is_sharp(edge, faces) { ends } else { 0.5 * (ends + mean(faces)) });
    }
    for (face, centre) in cage.faces.iter().zip(&centres) {
        let at = next.vertices.len();
        next.vertices.push(*centre);
        let before = |k: usize| face[(k + face.len() - 1) % face.len()];
        for (k, (a, b)) in sides(face).enumerate() {
            next.faces.push(vec![a, middle[&key(a, b)], at, middle[&key(before(k), a)]]);
        }
    }
    cage.inherit(&mut next, &middle);
    next
}
