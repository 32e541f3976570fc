//! The rules of the 3MF Core Specification 1.4.0 that are held against every file, each with its section there.
//!
//! "B.1" is the schema in the appendix, which section 2.3.2 makes a MUST; "OPC" the Open Packaging Conventions (ECMA-376,
//! part 2), which chapter 1 makes one.

use std::fmt;

/// A rule that a file can break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rule {
    /// Its name here.
    pub name: &'static str,
    /// Where it stands in the specification.
    pub section: &'static str,
    /// What it says, in short.
    pub text: &'static str,
    /// What is read is the same without it, or `repair-manifold` can put it right.
    pub is_mendable: bool,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "3MF Core {}, {}: {}", self.section, self.name, self.text)
    }
}

/// Declares the constants and the list of them all.
macro_rules! rules {
    ($($mendable:ident $constant:ident = $name:literal, $section:literal, $text:literal;)*) => {
        impl Rule {
            $(#[doc = $text] pub const $constant: Rule =
                Rule { name: $name, section: $section, text: $text, is_mendable: rules!($mendable) };)*
            /// Every rule, in the order of the specification.
            pub const ALL: &'static [Rule] = &[$(Rule::$constant),*];
        }
    };
    (strict) => { false };
    (mendable) => { true };
}

rules! {
    strict ZIP = "zip", "1.1", "the document is a ZIP archive";
    strict COMPRESSION = "compression", "1.1", "files are deflated or stored, and not encrypted";
    strict CONTENT_TYPES = "content-types", "1 (OPC)", "the package says in [Content_Types].xml what its parts are";
    strict START_PART = "start-part", "2.1.1", "one StartPart relationship points to the root 3D Model part";
    mendable MODEL_TYPE = "model-type", "2.1.1", "the 3D Model part has its content type";
    strict EXTERNAL = "external", "2.1.1", "nothing outside the package is referenced";
    mendable RELATIONSHIP_TWICE = "relationship-twice", "2.1.1",
        "there is one relationship of a type from one part to another, and its id is its own";
    strict TARGET = "target", "2.1.1", "targets of StartPart, Thumbnail and PrintTicket are in the package";
    mendable THUMBNAIL_FORMAT = "thumbnail-format", "2.1.3", "thumbnails are JPEG or PNG";
    mendable PRINT_TICKET = "print-ticket", "2.1.4", "a 3D Model part has one PrintTicket at most";
    strict PART_NAME = "part-name", "2.2.3 (OPC)",
        "part names are absolute, without empty, `.` or `..` segments, and differ in more than case";
    strict EXTENSION = "required-extension", "2.3.1", "a document whose required extensions are unknown is not read";
    strict WELL_FORMED = "well-formed", "2.3.2", "parts are well-formed XML with one root";
    strict ENCODING = "encoding", "2.3.2", "XML is UTF-8, and says nothing else";
    strict DTD = "dtd", "2.3.2", "XML has no DTD";
    strict SCHEMA = "schema", "2.3.2 (B.1)", "elements and attributes are those of the schema, in its order";
    mendable XSI = "xsi", "2.3.2", "no attributes from `xml` and `xsi` but xml:lang of the model";
    strict NUMBER = "number", "2.3.2 (B.1)", "numbers are written as the schema says, with a decimal point";
    strict NAMESPACE = "namespace", "2.3.3.1", "the model is in the core namespace, and prefixes are declared";
    mendable XML_SPACE = "xml-space", "2.3.4", "xml:space is not used";
    strict MATRIX = "matrix", "3.3", "a transform has twelve numbers";
    strict UNIT = "unit", "3.4", "the unit is micron, millimeter, centimeter, inch, foot or meter";
    strict MODEL = "model", "3.4", "a model has resources and a build";
    mendable RECOMMENDED = "recommended-extension", "3.4", "required extensions are not recommended too";
    strict ORDER = "order", "3.4", "resources are defined before they are referenced";
    mendable METADATA_NAME = "metadata-name", "3.4.1", "metadata names are well known, or prefixed by a declared namespace";
    mendable METADATA_TWICE = "metadata-twice", "3.4.1", "metadata names are unique";
    strict ID_UNIQUE = "id-unique", "3.4.2", "resource ids are unique within the model";
    strict ID = "id", "3.4.2 (B.1)", "resource ids are whole numbers from 1 to 2³¹ − 1";
    strict ITEM = "item", "3.4.3.1", "items reference objects that exist";
    strict OTHER = "other", "3.4.3.1", "the build does not reference objects of type `other`";
    strict OBJECT_TYPE = "object-type", "4", "the type of an object is one of five";
    mendable THUMBNAIL = "object-thumbnail", "4", "an object's thumbnail has its relationship";
    mendable PINDEX = "pindex", "4", "pindex comes with pid";
    mendable PROPERTY = "property", "4", "pid and pindex reference a property that exists";
    mendable COMPONENTS_PID = "components-pid", "4", "objects of components have no pid or pindex";
    mendable DEFAULT_PROPERTY = "default-property", "4",
        "an object with properties on triangles has pid and pindex itself";
    mendable MANIFOLD = "manifold-edges", "4.1", "every edge belongs to exactly two triangles";
    mendable ORIENTATION = "orientation", "4.1", "neighbours run along their common edge in opposite directions";
    mendable OUTWARD = "outward", "4.1", "normals point outwards: the volume is positive";
    mendable FOUR_TRIANGLES = "four-triangles", "4.1.4", "an object of type `model` has four triangles at least";
    strict INDEX = "index", "4.1.4.1", "v1, v2 and v3 are indices of vertices";
    mendable DISTINCT = "distinct", "4.1.4.1", "v1, v2 and v3 are distinct";
    mendable GRADIENT = "gradient", "4.1.4.1", "base materials form no gradients: p1, p2 and p3 are equal";
    mendable TRIANGLE_SET = "triangle-set", "4.1.5.1", "triangle sets have a name and an identifier of their own";
    strict COMPONENT = "component", "4.2.1", "components reference objects defined before";
    mendable BASE = "base", "5.1", "a base material has a name and a display colour";
    mendable COLOUR = "colour", "5.1.1", "a colour is #RRGGBB or #RRGGBBAA";
}
