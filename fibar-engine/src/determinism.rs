//! Is the same made twice the same? A plan is built in a second, empty store with another number of threads, and the first
//! artefact that differs is named with its byte and field.

mod field;

use crate::build::{self, BuildOptions, Finished};
use crate::plan::Plan;
use crate::store::{Action, Output, Rot};
use crate::{Digest, Result, Store};

/// What the comparison of one plan came to.
#[derive(Debug)]
pub struct Comparison {
    /// The object.
    pub name: String,
    /// Outputs that are the same.
    pub same: usize,
    /// Stages that do not promise to be deterministic, and those that read from them: not compared.
    pub skipped: Vec<String>,
    /// The first difference, in the order of the plan.
    pub difference: Option<Difference>,
}

/// Where two builds of the same thing differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The stage whose equal inputs gave unequal outputs.
    pub stage: String,
    /// The output port, and the file inside it for a folder; or `metrics` or `violations`.
    pub artefact: String,
    /// The first byte that differs, counted from 0.
    pub byte: usize,
    /// What that byte belongs to, as far as the format is known: a JSON pointer, an element of a PLY file.
    pub field: Option<String>,
    /// The text or bytes around it, first build and second.
    pub seen: [String; 2],
}

/// Builds plans twice, the second time in `second`, and compares stage by stage.
pub fn compare(plans: &[Plan], options: &BuildOptions<'_>, second: &Store) -> Result<Vec<Comparison>> {
    let first = build::run_plans(plans, options)?;
    let threads = Some(options.threads.unwrap_or(options.budget.cores) + 1);
    let again = build::run_plans(plans, &BuildOptions { store: second, threads, ..options.clone() })?;
    let stores = [options.store, second];
    let compare = |((plan, first), again): ((&Plan, &Vec<Finished>), &Vec<Finished>)| {
        Comparer { stores, plan, first, again }.compare()
    };
    plans.iter().zip(&first).zip(&again).map(compare).collect()
}

/// A fresh store below another, for the second build; remove it afterwards.
pub fn second_store(store: &Store) -> Result<Store> {
    let folder = store.new_work_folder("second-store")?;
    store.open_beside(&folder)
}

struct Comparer<'a> {
    stores: [&'a Store; 2],
    plan: &'a Plan,
    first: &'a [Finished],
    again: &'a [Finished],
}

impl Comparer<'_> {
    fn compare(&self) -> Result<Comparison> {
        let mut found =
            Comparison { name: self.plan.name.clone(), same: 0, skipped: Vec::new(), difference: None };
        let mut is_skipped = vec![false; self.plan.stages.len()];
        for (at, stage) in self.plan.stages.iter().enumerate() {
            let mut sources = stage.wires.iter().flat_map(|wire| &wire.sources);
            is_skipped[at] = !stage.plugin.description.deterministic || sources.any(|s| is_skipped[s.stage]);
            if is_skipped[at] {
                found.skipped.push(stage.id.clone());
                continue;
            }
            let actions = [&*self.first[at].action, &*self.again[at].action];
            found.difference = self.difference(&stage.id, actions)?;
            if found.difference.is_some() {
                return Ok(found);
            }
            found.same += actions[0].outputs.len();
        }
        Ok(found)
    }

    fn difference(&self, stage: &str, actions: [&Action; 2]) -> Result<Option<Difference>> {
        for (port, output) in &actions[0].outputs {
            let outputs = [output, &actions[1].outputs[port]];
            if outputs[0].digest == outputs[1].digest {
                continue;
            }
            let (artefact, bytes) = self.bytes(port, outputs).map_err(Rot::into_error)?;
            return Ok(Some(locate(stage, artefact, &bytes[0], &bytes[1])));
        }
        let json = |value: serde_json::Result<Vec<u8>>| value.expect("reports are plain data");
        for (what, a, b) in [
            (
                "metrics",
                json(serde_json::to_vec(&actions[0].metrics)),
                json(serde_json::to_vec(&actions[1].metrics)),
            ),
            (
                "violations",
                json(serde_json::to_vec(&actions[0].violations)),
                json(serde_json::to_vec(&actions[1].violations)),
            ),
        ] {
            if a != b {
                return Ok(Some(locate(stage, what.into(), &a, &b)));
            }
        }
        Ok(None)
    }

    /// The two versions of an artefact; of a folder, those of the first file that differs, or else the listings.
    fn bytes(&self, port: &str, outputs: [&Output; 2]) -> std::result::Result<(String, [Vec<u8>; 2]), Rot> {
        let [first, second] = self.stores;
        let read = |digests: [&Digest; 2]| -> std::result::Result<_, Rot> {
            Ok([first.read_blob(digests[0])?, second.read_blob(digests[1])?])
        };
        if !(outputs[0].tree && outputs[1].tree) {
            return Ok((
                format!("{port} ({})", outputs[0].name),
                read([&outputs[0].digest, &outputs[1].digest])?,
            ));
        }
        let trees = [first.read_tree(&outputs[0].digest)?, second.read_tree(&outputs[1].digest)?];
        let differs = |(a, b): &(&crate::store::TreeFile, &crate::store::TreeFile)| {
            a.path == b.path && a.digest != b.digest
        };
        match trees[0].files.iter().zip(&trees[1].files).find(differs) {
            Some((a, b)) => {
                Ok((format!("{port} ({}/{})", outputs[0].name, a.path), read([&a.digest, &b.digest])?))
            }
            None => Ok((format!("{port} (list of files)"), [trees[0].to_bytes(), trees[1].to_bytes()])),
        }
    }
}

fn locate(stage: &str, artefact: String, first: &[u8], second: &[u8]) -> Difference {
    let byte = first.iter().zip(second).take_while(|(a, b)| a == b).count();
    let (field, seen) = field::around(first, second, byte);
    Difference { stage: stage.into(), artefact, byte, field, seen }
}
