//! A part's XML, read forward only: elements with their attributes, one at a time.
//!
//! quick-xml splits the text; here are the rules of section 2.3: encoding, no DTD, namespaces, nothing from `xsi`.

use super::inspector::Inspector;
use super::rule::Rule;
use super::unpack::Budget;
use crate::error::{Place, ReadError};
use crate::words::shown;
use quick_xml::events::{BytesDecl, BytesStart, Event};
use quick_xml::name::{QName, ResolveResult};
use quick_xml::{NsReader, XmlVersion};
use std::io::BufRead;
use std::ops::Range;

/// The namespaces that are understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Namespace {
    /// No prefix and no default.
    None,
    /// 3MF core.
    Core,
    /// 3MF production extension: objects in parts of their own.
    Production,
    /// 3MF materials and properties extension; only groups of colours are understood.
    Materials,
    /// 3MF triangle sets.
    TriangleSets,
    /// OPC content types.
    ContentTypes,
    /// OPC relationships.
    Relationships,
    /// Attributes `xml:…`.
    Xml,
    /// Attributes `xsi:…`.
    Xsi,
    /// Any other: passed over.
    Foreign,
}

const NAMESPACES: [(&str, Namespace); 8] = [
    ("http://schemas.microsoft.com/3dmanufacturing/core/2015/02", Namespace::Core),
    ("http://schemas.microsoft.com/3dmanufacturing/production/2015/06", Namespace::Production),
    ("http://schemas.microsoft.com/3dmanufacturing/material/2015/02", Namespace::Materials),
    ("http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07", Namespace::TriangleSets),
    ("http://schemas.openxmlformats.org/package/2006/content-types", Namespace::ContentTypes),
    ("http://schemas.openxmlformats.org/package/2006/relationships", Namespace::Relationships),
    ("http://www.w3.org/XML/1998/namespace", Namespace::Xml),
    ("http://www.w3.org/2001/XMLSchema-instance", Namespace::Xsi),
];

impl Namespace {
    fn of(uri: &str) -> Namespace {
        NAMESPACES.iter().find(|(known, _)| *known == uri).map_or(Namespace::Foreign, |(_, it)| *it)
    }
}

/// The element that was opened last. Its texts lie in one buffer, which the next element takes over.
pub struct Element {
    /// Namespace of its name.
    pub namespace: Namespace,
    texts: String,
    name: Range<usize>,
    attributes: Vec<Attribute>,
    byte: u64,
}

struct Attribute {
    namespace: Namespace,
    name: Range<usize>,
    value: Range<usize>,
}

impl Element {
    /// Its name without prefix.
    pub fn name(&self) -> &str {
        &self.texts[self.name.clone()]
    }

    /// An attribute without prefix.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.get_in(Namespace::None, name)
    }

    /// An attribute in a namespace.
    pub fn get_in(&self, namespace: Namespace, name: &str) -> Option<&str> {
        let found =
            self.attributes.iter().find(|a| a.namespace == namespace && &self.texts[a.name.clone()] == name);
        found.map(|attribute| &self.texts[attribute.value.clone()])
    }

    fn push(&mut self, text: &str) -> Range<usize> {
        let start = self.texts.len();
        self.texts.push_str(text);
        start..self.texts.len()
    }
}

/// A part being read.
pub struct Xml<'a> {
    reader: NsReader<Box<dyn BufRead + 'a>>,
    buffer: Vec<u8>,
    /// Name of the part.
    part: String,
    budget: Budget,
    inspector: &'a Inspector,
    /// The element opened last.
    pub element: Element,
}

/// What comes next.
enum Token {
    Open,
    Close,
    Text,
    End,
}

impl<'a> Xml<'a> {
    /// A part's bytes, whose size `budget` watches.
    pub fn new(
        part: &str,
        source: Box<dyn BufRead + 'a>,
        budget: Budget,
        inspector: &'a Inspector,
    ) -> Xml<'a> {
        let mut reader = NsReader::from_reader(source);
        reader.config_mut().expand_empty_elements = true;
        let element = Element {
            namespace: Namespace::None,
            texts: String::new(),
            name: 0..0,
            attributes: Vec::new(),
            byte: 0,
        };
        Xml { reader, buffer: Vec::new(), part: part.into(), budget, inspector, element }
    }

    /// Moves into the root element, which must be of this name and namespace.
    pub fn open_root(&mut self, namespace: Namespace, name: &str) -> Result<(), ReadError> {
        match self.next()? {
            Token::Open if self.element.name() != name => {
                Err(self.error(format!("this is where `{name}` should be")).breaking(Rule::SCHEMA))
            }
            Token::Open if self.element.namespace != namespace => {
                Err(self.error("it is not in the namespace of its format").breaking(Rule::NAMESPACE))
            }
            Token::Open => Ok(()),
            _ => Err(self.failure("there is no element").breaking(Rule::WELL_FORMED)),
        }
    }

    /// Moves into the next child of the open element; false at its end. Whoever gets true must read the child to its end.
    pub fn open_child(&mut self) -> Result<bool, ReadError> {
        match self.next()? {
            Token::Open => Ok(true),
            Token::Close => Ok(false),
            Token::Text => Err(self.failure("text between elements").breaking(Rule::SCHEMA)),
            Token::End => Err(self.failure("the part ends within an element").breaking(Rule::WELL_FORMED)),
        }
    }

    /// The open element must have no children.
    pub fn close(&mut self) -> Result<(), ReadError> {
        match self.open_child()? {
            true if self.element.namespace == Namespace::Foreign => self.skip().and_then(|()| self.close()),
            true => Err(self.misplaced()),
            false => Ok(()),
        }
    }

    /// Passes over the rest of the open element, whatever it holds.
    pub fn skip(&mut self) -> Result<(), ReadError> {
        let mut depth = 1;
        while depth > 0 {
            match self.next()? {
                Token::Open => depth += 1,
                Token::Close => depth -= 1,
                Token::Text => {}
                Token::End => {
                    return Err(self.failure("the part ends within an element").breaking(Rule::WELL_FORMED));
                }
            }
        }
        Ok(())
    }

    /// After the root, nothing may follow.
    pub fn finish(&mut self) -> Result<(), ReadError> {
        match self.next()? {
            Token::End => Ok(()),
            _ => Err(self.failure("something follows the root element").breaking(Rule::WELL_FORMED)),
        }
    }

    /// Refuses attributes of the open element that are not among these; those of other namespaces are passed over.
    pub fn allow(&self, names: &[&str]) -> Result<(), ReadError> {
        let element = &self.element;
        for attribute in &element.attributes {
            let name = &element.texts[attribute.name.clone()];
            let is_lang =
                attribute.namespace == Namespace::Xml && name == "lang" && element.name() == "model";
            match attribute.namespace {
                Namespace::None if !names.contains(&name) => {
                    let message = format!("it has no attribute `{}`", shown(name));
                    return Err(self.error(message).breaking(Rule::SCHEMA));
                }
                Namespace::Xml if name == "space" => {
                    self.breach(Rule::XML_SPACE, "it has the attribute `xml:space`")?;
                }
                Namespace::Xml | Namespace::Xsi if !is_lang => {
                    self.breach(Rule::XSI, format!("it has an attribute `{}` of xml or xsi", shown(name)))?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// An attribute that must be there.
    pub fn require(&self, name: &str) -> Result<&str, ReadError> {
        let missing = || self.error(format!("the attribute `{name}` is missing")).breaking(Rule::SCHEMA);
        self.element.get(name).ok_or_else(missing)
    }

    /// The namespace that a prefix stands for here.
    pub fn namespace_of_prefix(&self, prefix: &str) -> Option<Namespace> {
        let name = format!("{prefix}:any");
        match self.reader.resolver().resolve_attribute(QName(&name)).0 {
            ResolveResult::Bound(namespace) => Some(Namespace::of(namespace.0)),
            _ => None,
        }
    }

    /// An error about an element that has no place here.
    pub fn misplaced(&self) -> ReadError {
        self.error("it has no place here").breaking(Rule::SCHEMA)
    }

    /// A broken rule at the open element.
    pub fn breach(&self, rule: Rule, message: impl Into<String>) -> Result<(), ReadError> {
        self.inspector.breach(rule, self.error(message))
    }

    /// An error at the open element.
    pub fn error(&self, message: impl Into<String>) -> ReadError {
        let message = format!("<{}>: {}", shown(self.element.name()), message.into());
        ReadError::new(Place::Byte(self.element.byte), message).inside(&self.part)
    }

    /// An error where reading stands.
    fn failure(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(Place::Byte(self.reader.buffer_position()), message).inside(&self.part)
    }

    fn next(&mut self) -> Result<Token, ReadError> {
        loop {
            self.buffer.clear();
            self.budget.begin_token();
            let byte = self.reader.buffer_position();
            match self.reader.read_event_into(&mut self.buffer) {
                Ok(Event::Start(start)) => {
                    self.element.byte = byte;
                    if let Err((rule, message)) = fill(&mut self.element, &start, &self.reader) {
                        return Err(self.failure(message).breaking(rule));
                    }
                    return Ok(Token::Open);
                }
                Ok(Event::End(_)) => return Ok(Token::Close),
                Ok(Event::Text(text)) if text.trim_ascii().is_empty() => {}
                Ok(Event::Text(_) | Event::CData(_) | Event::GeneralRef(_)) => return Ok(Token::Text),
                Ok(Event::DocType(_)) => return Err(self.failure("it has a DTD").breaking(Rule::DTD)),
                Ok(Event::Decl(declaration)) => {
                    if let Some(other) = other_encoding(&declaration) {
                        let message = format!("it declares the encoding `{}`", shown(&other));
                        return Err(self.failure(message).breaking(Rule::ENCODING));
                    }
                }
                Ok(Event::Eof) => return Ok(Token::End),
                Ok(_) => {}
                Err(error) => return Err(self.translate(error)),
            }
        }
    }

    fn translate(&self, error: quick_xml::Error) -> ReadError {
        match error {
            quick_xml::Error::Io(error) => match self.budget.excess() {
                Some(excess) => self.failure(excess),
                None => self.failure(format!("it cannot be unpacked: {error}")).breaking(Rule::ZIP),
            },
            quick_xml::Error::Encoding(_) => self.failure("it is not UTF-8").breaking(Rule::ENCODING),
            other => self.failure(shown_error(&other.to_string())).breaking(Rule::WELL_FORMED),
        }
    }
}

/// Takes over name and attributes of an element.
fn fill<R>(element: &mut Element, start: &BytesStart, reader: &NsReader<R>) -> Result<(), (Rule, String)> {
    element.texts.clear();
    element.attributes.clear();
    let (namespace, name) = reader.resolver().resolve_element(start.name());
    element.name = element.push(name.as_ref());
    element.namespace = resolved(namespace)?;
    for attribute in start.attributes() {
        let ill = |error: String| (Rule::WELL_FORMED, format!("in <{}>: {}", shown(name.as_ref()), error));
        let attribute = attribute.map_err(|error| ill(error.to_string()))?;
        if attribute.key.as_namespace_binding().is_some() {
            continue;
        }
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| ill(e.to_string()))?;
        let (namespace, name) = reader.resolver().resolve_attribute(attribute.key);
        let namespace = resolved(namespace)?;
        let (name, value) = (element.push(name.as_ref()), element.push(&value));
        element.attributes.push(Attribute { namespace, name, value });
    }
    Ok(())
}

fn resolved(result: ResolveResult) -> Result<Namespace, (Rule, String)> {
    match result {
        ResolveResult::Unbound => Ok(Namespace::None),
        ResolveResult::Bound(namespace) => Ok(Namespace::of(namespace.0)),
        ResolveResult::Unknown(prefix) => {
            Err((Rule::NAMESPACE, format!("the prefix `{}` is not declared", shown(&prefix))))
        }
    }
}

/// The encoding declared, if it is not UTF-8.
fn other_encoding(declaration: &BytesDecl) -> Option<String> {
    match declaration.encoding()? {
        Ok(name) if name.eq_ignore_ascii_case("utf-8") => None,
        Ok(name) => Some(name.into_owned()),
        Err(error) => Some(error.to_string()),
    }
}

/// The first line of somebody else's message.
fn shown_error(message: &str) -> String {
    message.lines().next().unwrap_or_default().chars().take(200).collect()
}
