//! The formats without packages: the same tetrahedron in each, and what becomes of damaged ones.

use super::*;
use proptest::prelude::*;
use std::io::Cursor;

/// The same tetrahedron in each format.
const OBJ: &str = "# four corners\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                   f 1 3 2\nf 1/1 2/2 4/3\nf -3//1 -2//1 \\\n -1//1\nf 3 1 4\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property float z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

const OFF: &str =
    "OFF\n# four corners\n4 4 6\n0 0 0\n1 0 0\n\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

fn read_mesh(bytes: &[u8], extension: &str) -> Result<TriangleMesh, ReadError> {
    read(Cursor::new(bytes), extension, &Limits::default()).map(|file| file.mesh)
}

fn corners(mesh: &TriangleMesh) -> Vec<[glam::DVec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

fn ascii_stl() -> String {
    let facet = |c: [glam::DVec3; 3]| {
        let vertex = |v: glam::DVec3| format!("vertex {:e} {} {}\n", v.x, v.y, v.z);
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", c.map(vertex).concat())
    };
    let tetrahedron = read_mesh(OBJ.as_bytes(), "obj").unwrap();
    format!("solid a b\n{}endsolid\n", corners(&tetrahedron).into_iter().map(facet).collect::<String>())
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b's'; 80];
    bytes.extend(4u32.to_le_bytes());
    for c in corners(&read_mesh(OBJ.as_bytes(), "obj").unwrap()) {
        bytes.extend([0; 12]);
        c.iter().flat_map(|v| v.to_array()).for_each(|x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn binary_ply(big_endian: bool) -> Vec<u8> {
    let endian = if big_endian { "big" } else { "little" };
    let mut bytes = PLY.split_inclusive("end_header\n").next().unwrap().as_bytes().to_vec();
    bytes =
        String::from_utf8(bytes).unwrap().replace("ascii", &format!("binary_{endian}_endian")).into_bytes();
    let mesh = read_mesh(OBJ.as_bytes(), "obj").unwrap();
    for v in &mesh.vertices {
        for x in v.to_array() {
            let x = x as f32;
            bytes.extend(if big_endian { x.to_be_bytes() } else { x.to_le_bytes() });
        }
        bytes.push(9);
    }
    for t in &mesh.triangles {
        bytes.push(3);
        t.iter().for_each(|v| bytes.extend(if big_endian { v.to_be_bytes() } else { v.to_le_bytes() }));
    }
    bytes
}

/// With normals and colours, and the counts right after the keyword.
fn coloured_off() -> String {
    let lines = OFF.replace("OFF\n# four corners\n4", "CNOFF4");
    lines.replace("0 0 1\n", "0 0 1 0 1 0 0.5 0.5 0.5 1\n").replace("3 1 2 3", "3 1 2 3 255 0 0")
}

fn samples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("obj", OBJ.into()),
        ("PLY", PLY.into()),
        ("stl", ascii_stl().into()),
        ("stl", binary_stl()),
        ("ply", binary_ply(false)),
        ("ply", binary_ply(true)),
        ("off", OFF.into()),
        ("off", coloured_off().into()),
    ]
}

#[test]
fn every_format_reads_the_same_triangles() {
    let expected = corners(&read_mesh(OBJ.as_bytes(), "obj").unwrap());
    assert_eq!(expected[2], [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z]);
    for (extension, bytes) in samples() {
        let mesh = read_mesh(&bytes, extension).unwrap();
        assert_eq!(corners(&mesh), expected, "{extension}");
    }
}

#[test]
fn errors_say_where_they_are() {
    let check = |extension: &str, bytes: &[u8], says: &str| {
        let error = read_mesh(bytes, extension).unwrap_err().to_string();
        assert!(error.contains(says), "{error:?} does not say {says:?}");
    };
    check("obj", b"", "empty");
    check("step", b"x", "`.step` is not a mesh format");
    check("obj", b"v 0 0 0\n", "no triangle");
    check("obj", b"v 0 0 0\nv 1 x 0\n", "line 2: `x` is not a number");
    check("obj", b"v 0 0\n", "line 1: a vertex has 3 coordinates");
    check("obj", b"v 0 0 nan\n", "line 1: `nan` is not a finite number");
    check("obj", b"v 0 0 0\nf 1 1\n", "line 2: a face needs 3 corners, has 2");
    check("obj", b"v 0 0 0\nf 1 1 2\n", "line 2: vertex 2 does not exist");
    check("obj", b"v 0 0 0\nf 1 1 0\n", "line 2: vertex 0 does not exist");
    check("obj", b"<html>\n", "line 1: `<html>` is not an OBJ keyword");
    check("stl", b"solid\nfacet normal 0 0 0\nouter loop\nvertex 1 2", "line 4: the file ends");
    check("stl", b"solid\nfacet normal 0 0 0\nouter lop\n", "line 3: `lop` where `loop`");
    check("stl", &binary_stl()[..200], "byte 200: the file ends, but 4 triangles need 284 bytes");
    check("stl", &[binary_stl(), vec![0; 3]].concat(), "byte 284: 3 bytes follow");
    check("stl", &[0; 20], "byte 20: the file ends");
    check("ply", b"ply\nformat ascii 2.0\n", "line 2: ");
    check("ply", b"plie\n", "line 1: ");
    check("ply", PLY.replace("element vertex 4", "element vertex 5").as_bytes(), "line ");
    check("ply", PLY.replace("element vertex 4", "element vertex 99999999999").as_bytes(), "line 4: ");
    check("ply", PLY.replace("3 2 0 3", "3 2 0 7").as_bytes(), "line 19: vertex 7 does not exist");
    check("ply", &binary_ply(true)[..230], "line 4: 4 × `vertex` need 52 bytes at least");
    let good = binary_ply(true);
    check("ply", &good[..good.len() - 1], "byte 287: a list of 3 does not fit");
    check("off", b"4 4 6\n", "line 1: an OFF file starts with `OFF`");
    check("off", b"4OFF\n", "line 1: `4OFF` is a variant of OFF");
    check("off", b"OFF BINARY\n", "line 1: binary OFF");
    check("off", b"OFF\n4\n", "line 2: here must be the numbers");
    check("off", OFF.replace("4 4 6", "4 400000000 6").as_bytes(), "line 3: 400000004 lines need");
    check("off", OFF.replace("4 4 6", "4 3 6").as_bytes(), "line 12: more lines");
    check("off", OFF.replace("3 2 0 3", "3 2 0 4").as_bytes(), "line 12: vertex 4 does not exist");
    check("off", OFF.replace("3 2 0 3", "4 2 0 3").as_bytes(), "line 12: `4 2 0 3` is not a count");
}

#[test]
fn a_shortened_file_is_an_error_or_an_open_mesh() {
    for (extension, bytes) in samples() {
        for length in 0..bytes.len().saturating_sub(2) {
            let whole = read_mesh(&bytes[..length], extension).is_ok_and(|m| m.triangles.len() == 4);
            assert!(!whole, "{extension} cut to {length} bytes");
        }
    }
}

proptest! {
    #[test]
    fn garbage_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..400), pick in 0..4usize) {
        let _ = read_mesh(&bytes, ["obj", "stl", "ply", "off"][pick]);
    }

    #[test]
    fn damage_never_panics(pick in 0..8usize, at in any::<prop::sample::Index>(), value in any::<u8>()) {
        let (extension, mut bytes) = samples().swap_remove(pick);
        let at = at.index(bytes.len());
        bytes[at] = value;
        if let Ok(mesh) = read_mesh(&bytes, extension) {
            let count = mesh.vertices.len() as u32;
            prop_assert!(mesh.triangles.iter().flatten().all(|&v| v < count));
            prop_assert!(mesh.vertices.iter().all(|v| v.is_finite()));
        }
    }
}
