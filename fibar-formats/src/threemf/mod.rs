//! 3MF by the Core Specification 1.4.0, with objects in parts of their own (production extension).
//!
//! `package.rs` opens the archive, `xml.rs` reads a part forward only, `model.rs`, `object.rs` and `mesh.rs` understand it,
//! `rule.rs` lists what is held against it, `assembly.rs` puts the items of the build together.

mod assembly;
mod inspector;
mod mesh;
mod model;
mod number;
mod object;
mod package;
mod rule;
mod unpack;
mod xml;

pub use rule::Rule;

use crate::error::{Place, ReadError};
use crate::{Limits, MeshFile};
use assembly::Assembly;
use inspector::Inspector;
use model::Model;
use package::Package;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{Read, Seek};
use unpack::Budget;

/// Bytes that any archive may unpack to.
const FREE_BYTES: u64 = 64 << 20;
/// Bytes that a byte of the archive may unpack to; XML of meshes reaches 30.
const MOST_RATIO: u64 = 100;

/// Reads a document of `length` bytes.
pub fn read<R: Read + Seek>(source: R, length: u64, limits: &Limits) -> Result<MeshFile, ReadError> {
    let inspector = Inspector::new(limits.mends_3mf);
    let budget = Budget::new(FREE_BYTES.saturating_add(length.saturating_mul(MOST_RATIO)));
    let mut package = Package::open(source, budget, &inspector)?;
    let start = package.start_part()?;
    let root = read_model(&mut package, &start, limits, &inspector)?;
    let mut others = BTreeMap::new();
    for path in paths(&root) {
        let Entry::Vacant(entry) = others.entry(path) else { continue };
        let model = read_model(&mut package, entry.key(), limits, &inspector)?;
        if let Some(stray) = paths(&model).next() {
            let error = ReadError::new(Place::File, format!("it leads on to `{stray}`"));
            return Err(error.inside(entry.key()).try_this("only the root model may name other parts"));
        }
        entry.insert(model);
    }
    let mut file = Assembly::new(&root, &others, &start)?.build(limits, &inspector)?;
    drop(package);
    file.notes = inspector.into_notes();
    Ok(file)
}

/// Reads one model part, and checks what it is related to.
fn read_model<R: Read + Seek>(
    package: &mut Package<R>,
    part: &str,
    limits: &Limits,
    inspector: &Inspector,
) -> Result<Model, ReadError> {
    package.check_model_type(part)?;
    let model = Model::read(&mut package.open_part(part)?, limits, inspector)?;
    let relationships = package.relationships(part)?;
    let tickets = relationships.iter().filter(|r| r.is_print_ticket()).count();
    if tickets > 1 {
        // Print tickets are for a printer: counted, not read.
        let error = ReadError::new(Place::File, format!("it has {tickets} PrintTickets")).inside(part);
        inspector.breach(Rule::PRINT_TICKET, error)?;
    }
    for thumbnail in &model.resources.thumbnails {
        let mut pictures = relationships.iter().filter(|r| r.is_thumbnail());
        if !pictures.any(|r| r.target.eq_ignore_ascii_case(thumbnail)) {
            let message = format!("no relationship leads to the thumbnail `{thumbnail}`");
            inspector.breach(Rule::THUMBNAIL, ReadError::new(Place::File, message).inside(part))?;
        }
    }
    Ok(model)
}

/// The other parts that a model names.
fn paths(model: &Model) -> impl Iterator<Item = String> {
    let components = model.resources.objects.iter().flat_map(|object| match &object.shape {
        object::Shape::Components(components) => components.as_slice(),
        object::Shape::Mesh(_) => &[],
    });
    components.chain(&model.items).filter_map(|reference| reference.path.clone())
}
