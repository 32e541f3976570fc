//! The 3MF Consortium's rules: a small sound package, and what one edit each makes of it.
//!
//! `3mf/sound` is the package, `3mf/cases.json` lists the edits with the rule that each breaks. The packages are left in
//! cargo's folder for tests, where `tests/peers/compare_3mf.py` holds them against lib3mf.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests")]

use fibar_formats::threemf::Rule;
use fibar_formats::{Limits, MeshFile, ReadError};
use std::collections::BTreeSet;
use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::{SimpleFileOptions, ZipWriter};

const MODEL: &str = "3D/3dmodel.model";

/// The parts of the sound package.
const SOUND: [(&str, &[u8]); 6] = [
    ("[Content_Types].xml", include_bytes!("3mf/sound/content-types.xml")),
    ("_rels/.rels", include_bytes!("3mf/sound/package.rels")),
    (MODEL, include_bytes!("3mf/sound/3dmodel.model")),
    ("3D/_rels/3dmodel.model.rels", include_bytes!("3mf/sound/model.rels")),
    ("3D/Metadata/Model_PT.xml", b"<PrintTicket/>"),
    ("Metadata/thumbnail.png", b"\x89PNG\r\n\x1a\n"),
];

/// An edit of the sound package, and the rule that it breaks.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    rule: String,
    name: String,
    /// The part whose text is edited.
    part: Option<String>,
    from: Option<String>,
    to: Option<String>,
    /// A second edit of the same part.
    also: Option<[String; 2]>,
    /// A part that is left out.
    remove: Option<String>,
    /// A part that is added, with its text.
    add: Option<[String; 2]>,
    /// Another encoding of the part.
    recode: Option<String>,
    /// What is done to the bytes of the archive.
    raw: Option<String>,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("3mf/cases.json")).unwrap()
}

impl Case {
    fn label(&self) -> String {
        format!("{}-{}", self.rule, self.name)
    }

    fn package(&self) -> Vec<u8> {
        let sound = SOUND.iter().filter(|(name, _)| self.remove.as_deref() != Some(name));
        let mut files: Vec<(String, Vec<u8>)> =
            sound.map(|(name, bytes)| (name.to_string(), bytes.to_vec())).collect();
        if let Some(part) = &self.part {
            let (_, bytes) = files.iter_mut().find(|(name, _)| name == part).unwrap();
            let text = self.edit(String::from_utf8(bytes.clone()).unwrap());
            *bytes = self.encode(&text);
        }
        files.extend(self.add.iter().map(|[name, text]| (name.clone(), text.clone().into_bytes())));
        let bytes = pack(&files);
        self.raw.as_deref().map_or(bytes.clone(), |how| spoil(bytes, how))
    }

    fn edit(&self, mut text: String) -> String {
        let pair = self.from.as_ref().zip(self.to.as_ref());
        let also = self.also.as_ref().map(|[from, to]| (from, to));
        for (from, to) in pair.into_iter().chain(also) {
            assert!(text.contains(from.as_str()), "{}: there is no {from:?}", self.label());
            text = text.replacen(from.as_str(), to, 1);
        }
        // What comes after the mark is cut off.
        text.split("\0CUT").next().unwrap().to_string()
    }

    fn encode(&self, text: &str) -> Vec<u8> {
        match self.recode.as_deref() {
            None => text.as_bytes().to_vec(),
            Some("utf-16") => {
                [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
            }
            Some("latin-1") => text.chars().map(|c| c as u8).collect(),
            Some(other) => panic!("{other}"),
        }
    }
}

fn pack(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Changes the headers of the model's file: method, flags, or attributes; or cuts the archive's end off.
fn spoil(mut bytes: Vec<u8>, how: &str) -> Vec<u8> {
    if how == "truncate" {
        bytes.truncate(bytes.len() - 30);
        return bytes;
    }
    // In the local header the name comes after 30 bytes, in the central one after 46.
    for (signature, header, flags, method) in [(b"PK\x03\x04", 30, 6, 8), (b"PK\x01\x02", 46, 8, 10)] {
        let is_header = |&at: &usize| {
            bytes[at..].starts_with(signature) && bytes[at + header..].starts_with(MODEL.as_bytes())
        };
        let at = (0..bytes.len() - header).find(is_header).unwrap();
        match how {
            "method" => bytes[at + method] = 12,
            "encrypt" => bytes[at + flags] |= 1,
            "symlink" if header == 46 => {
                bytes[at + 5] = 3;
                bytes[at + 38..at + 42].copy_from_slice(&(0o120777u32 << 16).to_le_bytes());
            }
            _ => {}
        }
    }
    bytes
}

fn read(bytes: &[u8], mends_3mf: bool) -> Result<MeshFile, ReadError> {
    fibar_formats::read(Cursor::new(bytes), "3mf", &Limits { mends_3mf, ..Limits::default() })
}

fn sound() -> Vec<u8> {
    pack(&SOUND.map(|(name, bytes)| (name.to_string(), bytes.to_vec())))
}

/// The sound model with one text replaced.
fn with(from: &str, to: &str) -> Result<MeshFile, ReadError> {
    let case = Case {
        rule: String::new(),
        name: String::new(),
        part: Some(MODEL.into()),
        from: Some(from.into()),
        to: Some(to.into()),
        also: None,
        remove: None,
        add: None,
        recode: None,
        raw: None,
    };
    read(&case.package(), false)
}

#[test]
fn the_sound_package_is_read() {
    let file = read(&sound(), false).unwrap();
    assert_eq!((file.mesh.triangles.len(), file.mm_per_unit, file.notes.len()), (8, Some(1.0), 0));
    let names: Vec<&str> = file.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["tower", "tower"]);
    assert_eq!(file.parts[0].colour, Some([1.0, 0.0, 0.0, 128.0 / 255.0]));
    let volume = |k: usize| file.mesh.volume_of(file.parts[k].triangles.clone());
    assert!((volume(0) - 1000.0 / 6.0).abs() < 1e-9);
    assert!((volume(1) - 1000.0 / 6.0).abs() < 1e-9, "a mirror turns nothing inside out");
    let (low, high) = file.mesh.bounds().unwrap();
    assert_eq!((low.to_array(), high.to_array()), ([1.0, 2.0, 3.0], [31.0, 12.0, 13.0]));
}

#[test]
fn every_broken_rule_is_refused_by_name() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("3mf-cases");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("sound.3mf"), sound()).unwrap();
    let mut wrong = Vec::new();
    for case in cases() {
        let (label, bytes) = (case.label(), case.package());
        std::fs::write(folder.join(format!("{label}.3mf")), &bytes).unwrap();
        match read(&bytes, false) {
            Err(error) if error.rule.is_some_and(|rule| rule.name == case.rule) => {
                let (text, section) = (error.to_string(), error.rule.unwrap().section);
                assert!(text.contains("3MF Core") && text.contains(section), "{text}");
            }
            other => wrong.push(format!("{label}: {:?}", other.map(|file| file.parts))),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_rule_has_a_case_and_labels_are_unique() {
    let all = cases();
    let covered: BTreeSet<&str> = all.iter().map(|case| case.rule.as_str()).collect();
    let rules: BTreeSet<&str> = Rule::ALL.iter().map(|rule| rule.name).collect();
    assert_eq!(covered, rules);
    let labels: BTreeSet<String> = all.iter().map(Case::label).collect();
    assert!(labels.len() == all.len() && all.len() >= 40, "{} cases", all.len());
}

/// With `mends_3mf` the harmless breaches become notes; all others stay refused.
#[test]
fn what_can_be_mended_is_let_pass_where_asked() {
    for case in cases() {
        let rule = Rule::ALL.iter().find(|rule| rule.name == case.rule).unwrap();
        match read(&case.package(), true) {
            Ok(file) => {
                assert!(rule.is_mendable, "{}", case.label());
                assert!(file.notes.iter().any(|note| note.contains(rule.name)), "{:?}", file.notes);
            }
            Err(error) => assert!(!rule.is_mendable, "{}: {error}", case.label()),
        }
    }
}

#[test]
fn what_the_rules_allow_is_read() {
    let volume = |file: &MeshFile| file.mesh.volume_of(0..file.mesh.triangles.len());
    for (unit, mm) in
        [("micron", 0.001), ("centimeter", 10.0), ("inch", 25.4), ("foot", 304.8), ("meter", 1000.0)]
    {
        assert_eq!(with("millimeter", unit).unwrap().mm_per_unit, Some(mm));
    }
    assert_eq!(with(" unit=\"millimeter\"", "").unwrap().mm_per_unit, Some(1.0));
    assert_eq!(with("x=\"10\"", "x=\" +.1e2 \"").unwrap(), with("x=\"10\"", "x=\"10\"").unwrap());
    assert_eq!(with("<mesh>", "<mesh v:a=\"1\"><!-- c --><?pi?>").unwrap().mesh.triangles.len(), 8);
    assert_eq!(
        with("<build>", "<build v:a=\"1\"><v:thing><v:x>text</v:x></v:thing>").unwrap().parts.len(),
        2
    );
    let left_out = with("type=\"model\"", "type=\"support\"").unwrap_err();
    assert!(left_out.to_string().contains("no triangle"), "{left_out}");
    let flat = with("-1 0 0 0 1 0", "0 0 0 0 1 0").unwrap_err();
    assert!(flat.to_string().contains("flat") && flat.rule.is_none(), "{flat}");
    let twice =
        with("</build>", "<item objectid=\"2\" transform=\"2 0 0 0 2 0 0 0 2 0 0 0\"/></build>").unwrap();
    assert!((volume(&twice) - 1000.0 / 6.0 * 10.0).abs() < 1e-9);
    assert_eq!(twice.parts.len(), 3);
}

/// Objects in a part of their own, in another unit.
#[test]
fn the_production_extension_names_other_parts() {
    let production = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
    let model = String::from_utf8(SOUND[2].1.to_vec()).unwrap();
    let root = model
        .replace("xmlns:v=", &format!("requiredextensions=\"p\" xmlns:p=\"{production}\" xmlns:v="))
        .replacen(
            "<component objectid=\"2\"",
            "<component p:path=\"/3D/Objects/tower.model\" objectid=\"2\"",
            1,
        );
    let other =
        model.replace("millimeter", "centimeter").replace(" thumbnail=\"/Metadata/thumbnail.png\"", "");
    let package = |other: &str| {
        let mut files = SOUND.map(|(name, bytes)| (name.to_string(), bytes.to_vec())).to_vec();
        files[2].1 = root.clone().into_bytes();
        files.push(("3D/Objects/tower.model".into(), other.as_bytes().to_vec()));
        read(&pack(&files), false)
    };
    let file = package(&other).unwrap();
    let volume = |k: usize| file.mesh.volume_of(file.parts[k].triangles.clone());
    assert!((volume(0) / volume(1) - 1000.0).abs() < 1e-9, "{} and {}", volume(0), volume(1));
    let missing = package(&other.replace("id=\"2\"", "id=\"9\"")).unwrap_err();
    assert!(missing.rule == Some(Rule::COMPONENT), "{missing}");
    let gone = root.replace("/3D/Objects", "/3D/Elsewhere");
    let mut files = SOUND.map(|(name, bytes)| (name.to_string(), bytes.to_vec())).to_vec();
    files[2].1 = gone.into_bytes();
    assert!(read(&pack(&files), false).unwrap_err().to_string().contains("not in the package"));
}

/// A megabyte of the same byte packs to a thousand: what unpacks beyond the budget is refused before it fills memory.
#[test]
fn bombs_are_refused() {
    let spaces = " ".repeat(80 << 20);
    let model =
        String::from_utf8(SOUND[2].1.to_vec()).unwrap().replace("<build>", &format!("{spaces}<build>"));
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in SOUND {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(if name == MODEL { model.as_bytes() } else { bytes }).unwrap();
    }
    let bytes = zip.finish().unwrap().into_inner();
    assert!(bytes.len() < 200_000);
    let error = read(&bytes, true).unwrap_err().to_string();
    assert!(error.contains("ZIP bomb") || error.contains("16 MB"), "{error}");
}

/// Components of components: 2^40 towers are refused by their number, not by running out of memory.
#[test]
fn components_that_multiply_are_counted_first() {
    let double = |k: usize| {
        let (id, below) = (k + 4, k + 3);
        format!(
            "<object id=\"{id}\"><components><component objectid=\"{below}\"/><component objectid=\"{below}\"/></components></object>\n"
        )
    };
    let doubles: String = (0..40).map(double).collect();
    let case = Case {
        rule: String::new(),
        name: String::new(),
        part: Some(MODEL.into()),
        from: Some("</resources>".into()),
        to: Some(format!("{doubles}</resources>")),
        also: Some(["<item objectid=\"3\"".into(), "<item objectid=\"43\"".into()]),
        remove: None,
        add: None,
        recode: None,
        raw: None,
    };
    let error = read(&case.package(), true).unwrap_err().to_string();
    assert!(error.contains("8796093022208 triangles exceed the limit"), "{error}");
}
