//! The same tetrahedron in many ways, and documents with one thing wrong.

use crate::{Limits, MeshFile, ReadError, read};
use base64::Engine;
use glam::DVec3;
use serde_json::{Value, json};
use std::io::Cursor;

/// Corners of a tetrahedron, and its triangles; metres, +Y up.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [u16; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];

fn buffer() -> Vec<u8> {
    let positions = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes());
    positions.chain(TRIANGLES.iter().flat_map(|k| k.to_le_bytes())).collect()
}

fn document() -> Value {
    let uri = base64::engine::general_purpose::STANDARD.encode(buffer());
    json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "tower", "mesh": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 0.5]}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72, "uri": format!("data:application/octet-stream;base64,{uri}")}]
    })
}

/// The document with values replaced, by JSON pointer; a pointer to nothing adds a key.
fn with(edits: &[(&str, Value)]) -> Result<MeshFile, ReadError> {
    let mut edited = document();
    for (pointer, value) in edits {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        edited.pointer_mut(parent).unwrap()[key] = value.clone();
    }
    read_bytes(edited.to_string().as_bytes())
}

fn read_bytes(bytes: &[u8]) -> Result<MeshFile, ReadError> {
    read(Cursor::new(bytes), "gltf", &Limits::default())
}

fn binary(json: &Value, chunk: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let numbers = |numbers: [u32; 2]| numbers.map(u32::to_le_bytes).concat();
    let total = 12 + 8 + text.len() + 8 + chunk.len();
    let header = [b"glTF".to_vec(), numbers([2, total as u32])].concat();
    let chunks =
        [numbers([text.len() as u32, 0x4E4F_534A]), text, numbers([chunk.len() as u32, 0x004E_4942])];
    [header, chunks.concat(), chunk.to_vec()].concat()
}

#[test]
fn metres_and_y_up_become_z_up() {
    let file = with(&[]).unwrap();
    let expected = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::NEG_Y];
    assert_eq!((file.mesh.vertices.as_slice(), file.mm_per_unit), (&expected[..], Some(1000.0)));
    assert_eq!(file.parts[0].name, "tower");
    assert_eq!(file.parts[0].triangles, 0..4);
    assert_eq!(file.parts[0].colour, Some([1.0, 0.0, 0.0, 0.5]));
    assert!(file.mesh.volume_of(0..4) > 0.0);
}

#[test]
fn a_glb_reads_as_its_document_with_embedded_buffers() {
    let mut inside = document();
    inside["buffers"][0].as_object_mut().unwrap().remove("uri");
    let bytes = binary(&inside, &buffer());
    assert_eq!(read_bytes(&bytes), with(&[]));
    for length in 0..bytes.len() {
        assert!(read_bytes(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
}

/// Volume and number of triangles.
#[track_caller]
fn check(edits: &[(&str, Value)], triangles: usize, volume: f64) {
    let file = with(edits).unwrap();
    let found = file.mesh.volume_of(0..file.mesh.triangles.len());
    assert_eq!(file.mesh.triangles.len(), triangles);
    assert!((found - volume / 6.0).abs() < 1e-12, "{found} is not {}", volume / 6.0);
}

#[test]
fn nodes_are_placed() {
    check(&[], 4, 1.0);
    check(&[("/nodes/0/scale", json!([2, 3, 4])), ("/nodes/0/translation", json!([5, 6, 7]))], 4, 24.0);
    check(&[("/nodes/0/scale", json!([-1, 1, 1]))], 4, 1.0);
    check(&[("/nodes/0/rotation", json!([0.0, 0.6, 0.0, 0.8]))], 4, 1.0);
    check(&[("/nodes/0/matrix", json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]))], 4, 8.0);
    let children =
        json!([{"children": [1, 2], "scale": [2, 2, 2]}, {"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}]);
    check(&[("/nodes", children.clone())], 8, 16.0);
    check(&[("/nodes", children), ("/scene", Value::Null), ("/scenes", json!([]))], 8, 16.0);
}

#[test]
fn numbers_come_in_many_ways() {
    let loose = with(&[("/meshes/0/primitives/0/indices", Value::Null)]).unwrap();
    assert_eq!((loose.mesh.vertices.len(), loose.mesh.triangles.len()), (4, 1));
    let strip = with(&[("/meshes/0/primitives/0/mode", json!(5))]).unwrap();
    assert_eq!(strip.mesh.triangles[..3], [[0, 2, 1], [1, 2, 0], [1, 0, 1]]);
    let fan = with(&[("/meshes/0/primitives/0/mode", json!(6))]).unwrap();
    assert_eq!(fan.mesh.triangles[..2], [[0, 2, 1], [0, 1, 0]]);
    let sparse = json!({"count": 1, "indices": {"bufferView": 1, "byteOffset": 2, "componentType": 5123},
        "values": {"bufferView": 0, "byteOffset": 12}});
    let moved = with(&[("/accessors/0/sparse", sparse)]).unwrap();
    assert_eq!(moved.mesh.vertices[2], DVec3::X, "vertex 2 takes the place of vertex 1");
    let zeros = with(&[("/accessors/0/bufferView", Value::Null)]).unwrap();
    assert_eq!(zeros.mesh.vertices, [DVec3::ZERO; 4]);
}

#[test]
fn errors_say_what_and_where() {
    let check = |edits: &[(&str, Value)], says: &[&str]| {
        let error = with(edits).unwrap_err();
        let text = format!("{error} try: {}", error.hint());
        says.iter().for_each(|part| assert!(text.contains(part), "{part:?} is not in {text:?}"));
    };
    check(
        &[("/buffers/0/uri", json!("tower.bin"))],
        &["buffers[0]", "another file, `tower.bin`", "one .glb"],
    );
    check(&[("/buffers/0/uri", json!("../../etc/passwd"))], &["another file"]);
    check(&[("/buffers/0/uri", json!("data:;base64,????"))], &["base64 is broken"]);
    check(&[("/buffers/0/byteLength", json!(73))], &["it has 72 bytes, not 73"]);
    check(&[("/asset/version", json!("1.0"))], &["it is glTF 1.0, not 2"]);
    check(
        &[("/extensionsRequired", json!(["KHR_draco_mesh_compression"]))],
        &["KHR_draco", "without compression"],
    );
    check(&[("/accessors/0/count", json!(5))], &["accessors[0]", "beyond its buffer"]);
    check(&[("/accessors/0/count", json!(u64::MAX))], &["accessors[0]", "exceed the limit"]);
    check(&[("/bufferViews/0/byteOffset", json!(u64::MAX))], &["beyond its buffer"]);
    check(&[("/bufferViews/0/byteStride", json!(u64::MAX))], &["beyond its buffer"]);
    check(&[("/accessors/0/type", json!("VEC2"))], &["its type is `VEC2`, not VEC3"]);
    check(&[("/accessors/1/componentType", json!(5126))], &["component type"]);
    check(&[("/accessors/1/byteOffset", json!(1))], &["beyond its buffer"]);
    check(&[("/meshes/0/primitives/0/indices", json!(9))], &["accessors[9]", "does not exist"]);
    check(&[("/nodes/0/mesh", json!(9))], &["meshes[9]"]);
    check(&[("/nodes/0/children", json!([0]))], &["nodes[0]", "two parents, or holds itself"]);
    check(&[("/scenes/0/nodes", json!([0, 0]))], &["two parents"]);
    check(&[("/scene", json!(3))], &["scenes[3]"]);
    check(&[("/accessors/0/count", json!(3))], &["vertex 3 does not exist, there are 3"]);
    check(&[("/nodes/0/mesh", Value::Null)], &["no triangle"]);
    assert!(read_bytes(b"{}").unwrap_err().to_string().contains("asset"));
    assert!(read_bytes(b"<html>").unwrap_err().hint().contains(".glb"));
}
