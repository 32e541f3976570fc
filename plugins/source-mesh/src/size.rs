//! Is this the size of an object, or were millimetres taken for metres or inches?

use crate::Params;
use crate::placement::Unit;
use fibar_formats::MeshFile;
use fibar_plugin::StageError;
use glam::DVec3;

/// Refuses what is implausibly small or large, and says what it would be in other units.
pub fn check(file: &MeshFile, params: &Params) -> Result<(), StageError> {
    let Some((low, high)) = file.mesh.bounds() else { return Ok(()) };
    let sides = (high - low) * params.scale;
    let mm = sides * file.mm_per_unit.unwrap_or(1.0);
    let [smallest, largest] = params.size_mm;
    let longest = mm.max_element();
    if (smallest..=largest).contains(&longest) {
        return Ok(());
    }
    let word = if longest < smallest { "small" } else { "large" };
    let source = match file.mm_per_unit {
        Some(_) => "by the unit that its file states",
        None => "if the numbers of its file, which states no unit, are mm",
    };
    let message = format!("the mesh measures {} mm {source}: implausibly {word}", in_words(mm));
    Err(StageError::input(message).param("/path").hint(hint(sides, params.size_mm)))
}

/// The units that give a plausible size, and how to insist.
fn hint(sides: DVec3, [smallest, largest]: [f64; 2]) -> String {
    let units = [("mm", Unit::Mm), ("cm", Unit::Cm), ("m", Unit::M), ("inch", Unit::Inch)];
    let sizes = units.map(|(name, unit)| (name, sides * unit.mm()));
    let plausible = sizes.iter().filter(|(_, size)| (smallest..=largest).contains(&size.max_element()));
    let mut texts: Vec<String> =
        plausible.map(|(name, size)| format!("units = \"{name}\" makes it {} mm", in_words(*size))).collect();
    texts.push("fit_mm = [x, y, z] scales it to a box".into());
    texts.push(format!("if it really is so, widen size_mm = [{smallest}, {largest}]"));
    texts.join("; ")
}

fn in_words(sides: DVec3) -> String {
    sides.to_array().map(three_digits).join(" × ")
}

/// Three digits that count, without an exponent.
fn three_digits(length: f64) -> String {
    let decimals = (2.0 - libm::floor(libm::log10(length.max(1e-9)))).clamp(0.0, 9.0) as usize;
    let text = format!("{length:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::mesh::TriangleMesh;

    /// A box of these sides, and what is said of it.
    #[track_caller]
    fn check_size(sides: [f64; 3], mm_per_unit: Option<f64>, says: &[&str]) {
        let mesh = TriangleMesh { vertices: vec![DVec3::ZERO, sides.into()], triangles: vec![] };
        let file = MeshFile { mesh, mm_per_unit, ..MeshFile::default() };
        match check(&file, &Params::default()) {
            Ok(()) => assert!(says.is_empty(), "{sides:?} passed"),
            Err(error) => {
                let text = format!("{error:?}");
                assert!(!says.is_empty(), "{text}");
                says.iter().for_each(|part| assert!(text.contains(part), "{part:?} is not in {text}"));
            }
        }
    }

    #[test]
    fn mixed_up_units_are_named() {
        check_size([5.0, 1.0, 1.0], None, &[]);
        check_size([1000.0, 1.0, 1.0], None, &[]);
        check_size(
            [0.155, 0.154, 0.12],
            None,
            &["0.155 × 0.154 × 0.12 mm", "states no unit", "small", "makes it 155 × 154 × 120 mm"],
        );
        check_size([4.0, 2.0, 1.0], None, &["units = \\\"inch\\\" makes it 102 × 50.8 × 25.4 mm"]);
        check_size(
            [120.0, 80.0, 60.0],
            Some(1000.0),
            &["120000 ×", "states: implausibly large", "makes it 120 × 80 × 60 mm"],
        );
        check_size([1e5, 1e5, 1e5], None, &["large", "fit_mm"]);
        check_size([0.12, 0.1, 0.1], Some(1000.0), &[]);
    }
}
