//! A 3D Model part: units, extensions, metadata, resources and the build.

use super::inspector::Inspector;
use super::mesh::open_only;
use super::object::{Reference, Resources, read_reference};
use super::rule::Rule;
use super::xml::{Namespace, Xml};
use crate::Limits;
use crate::error::ReadError;
use crate::words::shown;
use std::collections::BTreeSet;

/// A model part.
pub struct Model {
    /// Length of a 1 in it, mm.
    pub mm_per_unit: f64,
    /// Its objects.
    pub resources: Resources,
    /// What is printed.
    pub items: Vec<Reference>,
}

/// Metadata names that need no prefix.
const WELL_KNOWN: [&str; 9] = [
    "Title",
    "Designer",
    "Description",
    "Copyright",
    "LicenseTerms",
    "Rating",
    "CreationDate",
    "ModificationDate",
    "Application",
];

impl Model {
    /// Reads a part from its first byte to its last.
    pub fn read(xml: &mut Xml, limits: &Limits, inspector: &Inspector) -> Result<Model, ReadError> {
        xml.open_root(Namespace::Core, "model")?;
        xml.allow(&["unit", "requiredextensions", "recommendedextensions"])?;
        let mm_per_unit = unit(xml)?;
        check_extensions(xml)?;
        let (mut resources, mut items, mut names) = (None, None, BTreeSet::new());
        while xml.open_child()? {
            match (xml.element.namespace, xml.element.name()) {
                (Namespace::Core, "metadata") if resources.is_none() => read_metadata(xml, &mut names)?,
                (Namespace::Core, "resources") if resources.is_none() => {
                    resources = Some(Resources::read(xml, limits, inspector)?);
                }
                (Namespace::Core, "build") if items.is_none() => {
                    let known = resources.as_ref().ok_or_else(|| xml.error("it comes before the resources"));
                    items = Some(read_build(xml, known.map_err(|error| error.breaking(Rule::ORDER))?)?);
                }
                (Namespace::Core | Namespace::None, _) => return Err(xml.misplaced()),
                _ => xml.skip()?,
            }
        }
        xml.finish()?;
        let missing = |what: &str| xml.error(format!("the model has no {what}")).breaking(Rule::MODEL);
        let resources = resources.ok_or_else(|| missing("resources"))?;
        Ok(Model { mm_per_unit, resources, items: items.ok_or_else(|| missing("build"))? })
    }
}

fn unit(xml: &Xml) -> Result<f64, ReadError> {
    match xml.element.get("unit").unwrap_or("millimeter") {
        "micron" => Ok(0.001),
        "millimeter" => Ok(1.0),
        "centimeter" => Ok(10.0),
        "inch" => Ok(25.4),
        "foot" => Ok(304.8),
        "meter" => Ok(1000.0),
        other => Err(xml.error(format!("there is no unit `{}`", shown(other))).breaking(Rule::UNIT)),
    }
}

/// Every required extension must be one that is understood.
fn check_extensions(xml: &Xml) -> Result<(), ReadError> {
    let list = |name: &str| xml.element.get(name).unwrap_or_default().split_ascii_whitespace();
    for prefix in list("requiredextensions") {
        match xml.namespace_of_prefix(prefix) {
            Some(Namespace::Production | Namespace::Materials | Namespace::TriangleSets) => {}
            Some(_) => {
                let message = format!("the required extension `{}` is not known here", shown(prefix));
                return Err(xml
                    .error(message)
                    .breaking(Rule::EXTENSION)
                    .try_this("export it without that extension (lattices, slices, encryption, ...)"));
            }
            None => {
                let message = format!("the required extension `{}` is declared nowhere", shown(prefix));
                return Err(xml.error(message).breaking(Rule::NAMESPACE));
            }
        }
        if list("recommendedextensions").any(|other| other == prefix) {
            xml.breach(Rule::RECOMMENDED, format!("`{}` is both", shown(prefix)))?;
        }
    }
    Ok(())
}

fn read_metadata(xml: &mut Xml, names: &mut BTreeSet<String>) -> Result<(), ReadError> {
    xml.allow(&["name", "preserve", "type"])?;
    let name = xml.require("name")?.to_string();
    let is_named_well = match name.split_once(':') {
        Some((prefix, local)) => !local.is_empty() && xml.namespace_of_prefix(prefix).is_some(),
        None => WELL_KNOWN.contains(&name.as_str()),
    };
    if !is_named_well {
        xml.breach(Rule::METADATA_NAME, format!("its name is `{}`", shown(&name)))?;
    }
    if !names.insert(name) {
        xml.breach(Rule::METADATA_TWICE, "its name is there already")?;
    }
    xml.skip()
}

fn read_build(xml: &mut Xml, resources: &Resources) -> Result<Vec<Reference>, ReadError> {
    xml.allow(&[])?;
    let mut items = Vec::new();
    while open_only(xml, "item")? {
        xml.allow(&["objectid", "transform", "partnumber"])?;
        let item = read_reference(xml)?;
        if item.path.is_none() && !resources.by_id.contains_key(&item.object) {
            let message = format!("object {} does not exist", item.object);
            return Err(xml.error(message).breaking(Rule::ITEM));
        }
        items.push(item);
        xml.skip()?;
    }
    Ok(items)
}
