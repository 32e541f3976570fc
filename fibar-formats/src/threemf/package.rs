//! The archive as a package of the Open Packaging Conventions: parts, content types, relationships.

use super::inspector::Inspector;
use super::rule::Rule;
use super::unpack::{Budget, Counted};
use super::xml::{Namespace, Xml};
use crate::error::{Place, ReadError};
use crate::words::shown;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufReader, Read, Seek};
use zip::{CompressionMethod, ZipArchive};

const START_PART: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
const THUMBNAIL: &str = "http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail";
const PRINT_TICKET: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/printticket";
const MODEL_TYPE: &str = "application/vnd.ms-package.3dmanufacturing-3dmodel+xml";
const THUMBNAIL_TYPES: [&str; 2] = ["image/jpeg", "image/png"];
const CONTENT_TYPES_PART: &str = "/[Content_Types].xml";
/// More files than any document has: the list itself takes memory.
const MOST_FILES: usize = 65_536;

/// A package whose parts can be opened one after the other.
pub struct Package<'a, R> {
    archive: ZipArchive<R>,
    index: Index,
    budget: Budget,
    inspector: &'a Inspector,
}

/// What is in the package.
struct Index {
    /// Place in the archive by the part's name in lower case: names of parts are the same whatever their case.
    parts: BTreeMap<String, usize>,
    types: ContentTypes,
}

/// Content types by extension and by part, in lower case.
#[derive(Default)]
struct ContentTypes {
    by_extension: BTreeMap<String, String>,
    by_part: BTreeMap<String, String>,
}

/// A relationship from a part, or from the package.
pub struct Relationship {
    kind: String,
    /// Absolute name of the part it leads to.
    pub target: String,
}

impl Relationship {
    /// Whether it leads to a thumbnail.
    pub fn is_thumbnail(&self) -> bool {
        self.kind == THUMBNAIL
    }

    /// Whether it leads to a print ticket.
    pub fn is_print_ticket(&self) -> bool {
        self.kind == PRINT_TICKET
    }
}

impl<'a, R: Read + Seek> Package<'a, R> {
    /// Lists the parts, and reads their content types.
    pub fn open(source: R, budget: Budget, inspector: &'a Inspector) -> Result<Package<'a, R>, ReadError> {
        let mut archive = ZipArchive::new(source).map_err(|error| {
            ReadError::new(Place::File, format!("it is no ZIP archive: {error}")).breaking(Rule::ZIP)
        })?;
        let index = Index { parts: list(&mut archive)?, types: ContentTypes::default() };
        let mut package = Package { archive, index, budget, inspector };
        package.index.types = package.read_content_types()?;
        Ok(package)
    }

    /// The 3D Model part at the root.
    pub fn start_part(&mut self) -> Result<String, ReadError> {
        let relationships = self.relationships("/")?;
        let starts: Vec<&Relationship> = relationships.iter().filter(|r| r.kind == START_PART).collect();
        let [start] = starts[..] else {
            let error = ReadError::new(Place::File, format!("{} parts are named as the start", starts.len()));
            return Err(error.inside("/_rels/.rels").breaking(Rule::START_PART));
        };
        self.check_model_type(&start.target)?;
        Ok(start.target.clone())
    }

    /// The relationships of a part; of the package for `/`. None if it has no list of them.
    pub fn relationships(&mut self, part: &str) -> Result<Vec<Relationship>, ReadError> {
        let (folder, file) = part.rsplit_once('/').unwrap_or(("", part));
        let name = format!("{folder}/_rels/{file}.rels");
        if self.index.place(&name).is_none() {
            return Ok(Vec::new());
        }
        let mut xml = open(&mut self.archive, &self.index, &name, &self.budget, self.inspector)?;
        xml.open_root(Namespace::Relationships, "Relationships")?;
        let (mut found, mut ids, mut pairs) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        while xml.open_child()? {
            let Some(relationship) = read_relationship(&mut xml, &self.index, &mut ids)? else { continue };
            if !pairs.insert((relationship.kind.clone(), relationship.target.to_lowercase())) {
                xml.breach(Rule::RELATIONSHIP_TWICE, "the same relationship is there already")?;
            }
            found.push(relationship);
        }
        xml.finish()?;
        Ok(found)
    }

    /// Refuses a model part of another content type.
    pub fn check_model_type(&self, part: &str) -> Result<(), ReadError> {
        match self.index.types.of(part) {
            Some(MODEL_TYPE) => Ok(()),
            other => {
                let message = format!("its content type is `{}`", shown(other.unwrap_or("not given")));
                let error = ReadError::new(Place::File, message).inside(part);
                self.inspector.breach(Rule::MODEL_TYPE, error)
            }
        }
    }

    /// Begins to read a part.
    pub fn open_part(&mut self, part: &str) -> Result<Xml<'_>, ReadError> {
        open(&mut self.archive, &self.index, part, &self.budget, self.inspector)
    }

    fn read_content_types(&mut self) -> Result<ContentTypes, ReadError> {
        if self.index.place(CONTENT_TYPES_PART).is_none() {
            let error = ReadError::new(Place::File, "there is no [Content_Types].xml");
            return Err(error.breaking(Rule::CONTENT_TYPES));
        }
        let mut types = ContentTypes::default();
        let mut xml = self.open_part(CONTENT_TYPES_PART)?;
        xml.open_root(Namespace::ContentTypes, "Types")?;
        while xml.open_child()? {
            let (list, key) = match xml.element.name() {
                "Default" => (&mut types.by_extension, "Extension"),
                "Override" => (&mut types.by_part, "PartName"),
                _ => return Err(xml.misplaced()),
            };
            let (key, kind) = (xml.require(key)?.to_lowercase(), xml.require("ContentType")?.to_lowercase());
            if list.insert(key, kind).is_some() {
                return Err(xml.error("it is there already").breaking(Rule::CONTENT_TYPES));
            }
            xml.close()?;
        }
        xml.finish()?;
        Ok(types)
    }
}

/// Begins to read a part of an archive.
fn open<'x, R: Read + Seek>(
    archive: &'x mut ZipArchive<R>,
    index: &Index,
    part: &str,
    budget: &Budget,
    inspector: &'x Inspector,
) -> Result<Xml<'x>, ReadError> {
    let missing =
        || ReadError::new(Place::File, "it is not in the package").inside(part).breaking(Rule::TARGET);
    let place = index.place(part).ok_or_else(missing)?;
    let file = archive.by_index(place).map_err(|error| {
        ReadError::new(Place::File, format!("it cannot be unpacked: {error}"))
            .inside(part)
            .breaking(Rule::ZIP)
    })?;
    let counted = Counted { inner: file, budget: budget.clone() };
    Ok(Xml::new(part, Box::new(BufReader::with_capacity(1 << 16, counted)), budget.clone(), inspector))
}

/// Names and places of the files; folders are left out.
fn list<R: Read + Seek>(archive: &mut ZipArchive<R>) -> Result<BTreeMap<String, usize>, ReadError> {
    if archive.len() > MOST_FILES {
        let message = format!("{} files in a package are more than {MOST_FILES}", archive.len());
        return Err(ReadError::new(Place::File, message).breaking(Rule::ZIP));
    }
    let mut parts = BTreeMap::new();
    for place in 0..archive.len() {
        let broken = |error| {
            ReadError::new(Place::File, format!("its list of files is broken: {error}")).breaking(Rule::ZIP)
        };
        let file = archive.by_index_data(place).map_err(broken)?;
        let name = file.name().map_err(broken)?.into_owned();
        if name.ends_with('/') {
            continue;
        }
        let part = format!("/{name}");
        let blame = |what: &str, rule| ReadError::new(Place::File, what).inside(shown(&part)).breaking(rule);
        if file.is_symlink() {
            return Err(blame("it is a symbolic link", Rule::PART_NAME));
        }
        if let Some(fault) = fault_of_name(&part) {
            return Err(blame(&format!("its name {fault}"), Rule::PART_NAME));
        }
        let is_plain = matches!(file.compression(), CompressionMethod::Stored | CompressionMethod::Deflated);
        if !is_plain || file.encrypted() {
            return Err(blame("it is encrypted, or compressed in another way", Rule::COMPRESSION));
        }
        if parts.insert(part.to_lowercase(), place).is_some() {
            return Err(blame("its name is there already", Rule::PART_NAME));
        }
    }
    Ok(parts)
}

fn read_relationship(
    xml: &mut Xml,
    index: &Index,
    ids: &mut BTreeSet<String>,
) -> Result<Option<Relationship>, ReadError> {
    if xml.element.name() != "Relationship" {
        return Err(xml.misplaced());
    }
    xml.allow(&["Id", "Type", "Target", "TargetMode"])?;
    let (id, kind) = (xml.require("Id")?.to_string(), xml.require("Type")?.to_string());
    let target = xml.require("Target")?.to_string();
    if !ids.insert(id) {
        xml.breach(Rule::RELATIONSHIP_TWICE, "its Id is there already")?;
    }
    let is_followed = [START_PART, THUMBNAIL, PRINT_TICKET].contains(&kind.as_str());
    let is_external = xml.element.get("TargetMode") == Some("External");
    if is_followed && is_external {
        let message = format!("it leads out of the package, to `{}`", shown(&target));
        return Err(xml.error(message).breaking(Rule::EXTERNAL));
    }
    if is_followed {
        check_target(xml, index, &kind, &target)?;
    }
    xml.close()?;
    // Relations that nobody here follows may lead anywhere.
    Ok((!is_external).then_some(Relationship { kind, target }))
}

/// Targets that are followed: their names, that they are there, that thumbnails are pictures.
fn check_target(xml: &Xml, index: &Index, kind: &str, target: &str) -> Result<(), ReadError> {
    if let Some(fault) = fault_of_name(target) {
        let message = format!("its target `{}` {fault}", shown(target));
        return Err(xml.error(message).breaking(Rule::PART_NAME));
    }
    if index.place(target).is_none() {
        let message = format!("its target `{}` is not in the package", shown(target));
        return Err(xml.error(message).breaking(Rule::TARGET));
    }
    let is_picture = index.types.of(target).is_some_and(|kind| THUMBNAIL_TYPES.contains(&kind));
    if kind == THUMBNAIL && !is_picture {
        xml.breach(Rule::THUMBNAIL_FORMAT, format!("`{}` is not image/jpeg or image/png", shown(target)))?;
    }
    Ok(())
}

/// What is wrong with the name of a part: it could lead out of the package, or is none.
fn fault_of_name(part: &str) -> Option<&'static str> {
    let Some(path) = part.strip_prefix('/') else { return Some("does not begin with `/`") };
    if path.contains(['\\', ':']) || path.chars().any(char::is_control) {
        return Some("has a backslash, colon or control character");
    }
    // `_rels/.rels` is the one name of the packaging conventions that begins with a period.
    let is_rels = |segment: &str| segment == ".rels";
    match path.split('/').find(|s| s.is_empty() || (s.starts_with('.') && !is_rels(s)) || s.ends_with('.')) {
        Some(_) => Some("has a segment that is empty, or that begins or ends with a period"),
        None => None,
    }
}

impl Index {
    fn place(&self, part: &str) -> Option<usize> {
        self.parts.get(&part.to_lowercase()).copied()
    }
}

impl ContentTypes {
    fn of(&self, part: &str) -> Option<&str> {
        let part = part.to_lowercase();
        let by_extension = || self.by_extension.get(part.rsplit_once('.')?.1);
        self.by_part.get(&part).or_else(by_extension).map(String::as_str)
    }
}
