//! What becomes of a broken rule: an error, or, where that is wanted and harmless, a note.

use super::rule::Rule;
use crate::error::ReadError;
use std::cell::RefCell;

/// Decides on broken rules, and remembers those that were let pass.
pub struct Inspector {
    is_lenient: bool,
    notes: RefCell<Vec<String>>,
}

/// Notes beyond this number are not kept.
const MOST_NOTES: usize = 20;

impl Inspector {
    /// A strict one refuses every broken rule, a lenient one only what cannot be mended.
    pub fn new(is_lenient: bool) -> Inspector {
        Inspector { is_lenient, notes: RefCell::default() }
    }

    /// Passes judgement on a broken rule.
    pub fn breach(&self, rule: Rule, error: ReadError) -> Result<(), ReadError> {
        let error = error.breaking(rule);
        if self.is_lenient && rule.is_mendable {
            self.note(error.to_string());
            return Ok(());
        }
        match rule.is_mendable {
            true => Err(error.try_this(
                "export it again from a program that keeps to the specification, or let it pass by `broken_3mf = \"mend\"`",
            )),
            false => Err(error),
        }
    }

    /// Something that the user should know.
    pub fn note(&self, note: String) {
        let mut notes = self.notes.borrow_mut();
        if notes.len() < MOST_NOTES && !notes.contains(&note) {
            notes.push(note);
        }
    }

    /// All notes.
    pub fn into_notes(self) -> Vec<String> {
        self.notes.into_inner()
    }
}
