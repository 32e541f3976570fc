//! The JSON of glTF 2.0, as far as it says something about shapes. Whatever else is there is passed over.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// The root.
#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    pub asset: Asset,
    pub scene: Option<usize>,
    #[serde(default)]
    pub extensions_required: List<String>,
    #[serde(default)]
    pub scenes: List<Scene>,
    #[serde(default)]
    pub nodes: List<Node>,
    #[serde(default)]
    pub meshes: List<Mesh>,
    #[serde(default)]
    pub materials: List<Material>,
    #[serde(default)]
    pub accessors: List<Accessor>,
    #[serde(default)]
    pub buffer_views: List<View>,
    #[serde(default)]
    pub buffers: List<Buffer>,
}

#[derive(serde::Deserialize)]
pub struct Asset {
    pub version: String,
}

#[derive(serde::Deserialize)]
pub struct Scene {
    #[serde(default)]
    pub nodes: List<usize>,
}

#[derive(serde::Deserialize)]
pub struct Node {
    pub name: Option<String>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    #[serde(default)]
    pub children: List<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(serde::Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    #[serde(default)]
    pub primitives: List<Primitive>,
}

#[derive(serde::Deserialize)]
pub struct Primitive {
    #[serde(default)]
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
}

#[derive(Default, serde::Deserialize)]
pub struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
}

#[derive(serde::Deserialize)]
pub struct Material {
    #[serde(rename = "pbrMetallicRoughness")]
    pub surface: Option<Surface>,
}

#[derive(serde::Deserialize)]
pub struct Surface {
    #[serde(rename = "baseColorFactor")]
    pub base_colour: Option<[f64; 4]>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

/// Values that replace some of an accessor's.
#[derive(serde::Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct View {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
}

/// A list of at most a million: three bytes of text each may not become gigabytes.
pub struct List<T>(pub Vec<T>);

const LONGEST: usize = 1_000_000;

impl<T> Default for List<T> {
    fn default() -> Self {
        List(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Items<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Items<T> {
            type Value = List<T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "a list")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<List<T>, A::Error> {
                let mut list = Vec::new();
                while let Some(item) = items.next_element()? {
                    if list.len() >= LONGEST {
                        return Err(A::Error::custom("a list of more than a million"));
                    }
                    list.push(item);
                }
                Ok(List(list))
            }
        }
        deserializer.deserialize_seq(Items(PhantomData))
    }
}
