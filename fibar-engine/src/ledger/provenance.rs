//! `provenance.json`: an in-toto statement with SLSA provenance: which files, made by which plugins from which inputs, all by
//! digest. No time, host or path is in it, so that equal builds have equal statements.

use super::PublishedFile;
use crate::build::Finished;
use crate::plan::Plan;
use crate::store::Rot;
use crate::{Digest, Store};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Names what the parameters of the predicate mean.
const BUILD_TYPE: &str = "urn:fibar:build:1";

/// The text of the file.
pub(super) fn text(
    plan: &Plan,
    finished: &[Finished],
    files: &[PublishedFile],
    store: &Store,
) -> Result<String, Rot> {
    let statement = json!({
        "_type": "https://in-toto.io/Statement/v1",
        "subject": subjects(files, store)?,
        "predicateType": "https://slsa.dev/provenance/v1",
        "predicate": {
            "buildDefinition": {
                "buildType": BUILD_TYPE,
                "externalParameters": {"object": plan.name, "set": plan.changes},
                "internalParameters": {"platform": platform(), "stages": stages(plan, finished)},
                "resolvedDependencies": dependencies(plan),
            },
            "runDetails": {
                "builder": {
                    "id": "urn:fibar:engine",
                    "version": {"fibar": env!("CARGO_PKG_VERSION")},
                },
            },
        },
    });
    Ok(serde_json::to_string_pretty(&statement).expect("a statement is plain data") + "\n")
}

fn platform() -> String {
    format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
}

/// Every published file; those of a folder one by one, as in-toto digests name bytes.
fn subjects(files: &[PublishedFile], store: &Store) -> Result<Vec<Value>, Rot> {
    let mut subjects = Vec::new();
    for file in files {
        if !file.tree {
            subjects.push(descriptor(&file.name, &file.digest));
            continue;
        }
        for inner in store.read_tree(&file.digest)?.files {
            subjects.push(descriptor(&format!("{}/{}", file.name, inner.path), &inner.digest));
        }
    }
    Ok(subjects)
}

fn descriptor(name: &str, digest: &Digest) -> Value {
    json!({"name": name, "digest": {"sha256": digest}})
}

/// The key of every stage with its whole manifest: parameters, seed, inputs, plugin.
fn stages(plan: &Plan, finished: &[Finished]) -> Vec<Value> {
    let stage = |(stage, finished): (&crate::plan::PlannedStage, &Finished)| json!({"id": stage.id, "key": finished.key, "manifest": finished.action.manifest});
    plan.stages.iter().zip(finished).map(stage).collect()
}

/// Recipe and profiles, files that parameters name, and plugins.
fn dependencies(plan: &Plan) -> Vec<Value> {
    let mut found: BTreeMap<String, Digest> = BTreeMap::new();
    for source in &plan.sources {
        found.insert(format!("recipe/{}", source.name), source.digest);
    }
    for stage in &plan.stages {
        found.insert(format!("plugin/{}", stage.plugin.name), stage.plugin.digest);
        for file in &stage.files {
            let name = file.path.file_name().unwrap_or_default().to_string_lossy();
            found.insert(format!("file/{}{}/{name}", stage.id, file.pointer), file.digest);
        }
    }
    found.iter().map(|(name, digest)| descriptor(name, digest)).collect()
}
