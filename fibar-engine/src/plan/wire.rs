//! Which output feeds which input. Ports are typed: an unwired input takes the nearest earlier output of its type.

use crate::plugin::Plugin;
use crate::recipe::{From, Node, RecipeStage};
use fibar_core::diagnostic::{Diagnostic, did_you_mean};
use fibar_core::protocol::{Arity, InputPort};
use std::sync::Arc;

/// What feeds an input port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wire {
    /// The input port.
    pub port: String,
    /// One for a port of arity one, none or one for an optional one, any number for many.
    pub sources: Vec<WireSource>,
}

/// An output of a stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WireSource {
    /// Index of the stage in the plan.
    pub stage: usize,
    /// Its output port.
    pub port: String,
}

/// All stages of a recipe with their plugins, where these are known.
pub(super) struct Wiring<'a> {
    pub stages: &'a [(RecipeStage, Option<Arc<Plugin>>)],
}

impl Wiring<'_> {
    /// The wires of a stage, or what is wrong with them.
    pub fn wires(&self, at: usize, findings: &mut Vec<Diagnostic>) -> Vec<Wire> {
        let (stage, Some(plugin)) = &self.stages[at] else { return Vec::new() };
        self.check_ports(stage, plugin, findings);
        let mut wires = Vec::new();
        for input in &plugin.description.inputs {
            match self.sources(at, input) {
                Ok(sources) => wires.push(Wire { port: input.name.clone(), sources }),
                Err(finding) => findings.push(*finding),
            }
        }
        wires
    }

    fn check_ports(&self, stage: &RecipeStage, plugin: &Plugin, findings: &mut Vec<Diagnostic>) {
        let From::Ports(entries) = &stage.from else { return };
        let ports = || plugin.description.inputs.iter().map(|p| p.name.as_str());
        for entry in entries.iter().filter(|e| !ports().any(|port| port == e.key)) {
            let finding = entry.key_error(format!("`{}` has no input `{}`", plugin.name, entry.key));
            findings.push(match did_you_mean(&entry.key, ports()) {
                Some(port) => finding.hint(format!("did you mean `{port}`?")),
                None => finding.hint(format!("its inputs: {}", ports().collect::<Vec<_>>().join(", "))),
            });
        }
    }

    fn sources(&self, at: usize, input: &InputPort) -> Result<Vec<WireSource>, Box<Diagnostic>> {
        let (stage, _) = &self.stages[at];
        match &stage.from {
            From::Ports(entries) => {
                if let Some(entry) = entries.iter().find(|e| e.key == input.name) {
                    return self.named(&entry.value, input).map(|source| vec![source]);
                }
            }
            From::Stage(node) => {
                let named = self.find_stage(node, node.as_str().unwrap_or(""))?;
                if let [port] = self.outputs_of_kind(named, &input.kind).as_slice() {
                    return Ok(vec![WireSource { stage: named, port: port.clone() }]);
                }
            }
            From::Nearest => {}
        }
        self.nearest(at, input)
    }

    /// `"stage"` or `"stage.port"`.
    fn named(&self, node: &Node, input: &InputPort) -> Result<WireSource, Box<Diagnostic>> {
        let Some(text) = node.as_str() else {
            return Err(Box::new(node.error("name a stage, or `stage.port`")));
        };
        let (id, port) = text.split_once('.').map_or((text, None), |(id, port)| (id, Some(port)));
        let stage = self.find_stage(node, id)?;
        let fitting = self.outputs_of_kind(stage, &input.kind);
        match (fitting.as_slice(), port) {
            (fitting, Some(port)) if fitting.iter().any(|p| p == port) => {
                Ok(WireSource { stage, port: port.into() })
            }
            ([only], None) => Ok(WireSource { stage, port: only.clone() }),
            ([], None) if self.stages[stage].1.is_none() => Err(Box::new(silent())),
            ([], _) => {
                let message = format!("`{text}` gives no `{}`, which `{}` needs", input.kind, input.name);
                Err(Box::new(node.error(message).note(self.outputs_text(stage))))
            }
            (several, None) => {
                let finding = node.error(format!("`{id}` gives several `{}`", input.kind));
                Err(Box::new(finding.hint(format!("say which: {}", join_ports(id, several)))))
            }
            (_, Some(port)) => {
                let finding = node.error(format!("`{id}` gives no `{}` called `{port}`", input.kind));
                Err(Box::new(finding.note(self.outputs_text(stage))))
            }
        }
    }

    fn find_stage(&self, node: &Node, id: &str) -> Result<usize, Box<Diagnostic>> {
        let ids = || self.stages.iter().map(|(stage, _)| stage.id.as_str());
        ids().position(|other| other == id).ok_or_else(|| {
            let finding = node.error(format!("there is no stage `{id}`"));
            Box::new(match did_you_mean(id, ids()) {
                Some(guess) => finding.hint(format!("did you mean `{guess}`?")),
                None => finding.hint(format!("stages: {}", ids().collect::<Vec<_>>().join(", "))),
            })
        })
    }

    fn nearest(&self, at: usize, input: &InputPort) -> Result<Vec<WireSource>, Box<Diagnostic>> {
        if input.arity == Arity::Many {
            let all = (0..at).flat_map(|stage| {
                let ports = self.outputs_of_kind(stage, &input.kind);
                ports.into_iter().map(move |port| WireSource { stage, port })
            });
            return Ok(all.collect());
        }
        for stage in (0..at).rev() {
            match self.outputs_of_kind(stage, &input.kind).as_slice() {
                [] => {}
                [port] => return Ok(vec![WireSource { stage, port: port.clone() }]),
                several => return Err(Box::new(self.tie(at, input, stage, several))),
            }
        }
        if input.arity == Arity::Optional {
            return Ok(Vec::new());
        }
        Err(Box::new(self.missing(at, input)))
    }

    fn tie(&self, at: usize, input: &InputPort, stage: usize, ports: &[String]) -> Diagnostic {
        let (reader, writer) = (&self.stages[at].0, &self.stages[stage].0);
        let message = format!("`{}` gives several `{}` for input `{}`", writer.id, input.kind, input.name);
        let choice = join_ports(&writer.id, ports);
        reader
            .use_node
            .error(message)
            .hint(format!("wire it: from = {{ {} = … }} with one of {choice}", input.name))
    }

    fn missing(&self, at: usize, input: &InputPort) -> Diagnostic {
        let stage = &self.stages[at].0;
        if self.stages[..at].iter().any(|(_, plugin)| plugin.is_none()) {
            return silent();
        }
        let message = format!("nothing before `{}` gives the `{}` it needs", stage.id, input.kind);
        let finding = stage.use_node.error(message).note(format!("input `{}`: {}", input.name, input.doc));
        let later = self.stages[at..]
            .iter()
            .enumerate()
            .find(|(i, _)| !self.outputs_of_kind(at + i, &input.kind).is_empty());
        match later {
            Some((_, (later, _))) => finding.hint(format!("move it after `{}`", later.id)),
            None => finding
                .hint(format!("add a stage that gives `{}`; `fibar plugin list` shows them", input.kind)),
        }
    }

    fn outputs_of_kind(&self, stage: usize, kind: &str) -> Vec<String> {
        let outputs = self.stages[stage].1.iter().flat_map(|plugin| &plugin.description.outputs);
        outputs.filter(|port| port.kind == kind).map(|port| port.name.clone()).collect()
    }

    fn outputs_text(&self, stage: usize) -> String {
        let outputs = self.stages[stage].1.iter().flat_map(|plugin| &plugin.description.outputs);
        let outputs: Vec<String> = outputs.map(|port| format!("{} ({})", port.name, port.kind)).collect();
        format!("`{}` gives {}", self.stages[stage].0.id, outputs.join(", "))
    }
}

/// A finding that follows from another one already reported; filtered out before showing.
pub(super) fn silent() -> Diagnostic {
    Diagnostic::error("")
}

fn join_ports(stage: &str, ports: &[String]) -> String {
    ports.iter().map(|port| format!("\"{stage}.{port}\"")).collect::<Vec<_>>().join(", ")
}

/// Stage indices in an order where every stage follows its sources, earliest in the recipe first; or the stages of a
/// cycle.
pub(super) fn order(wires: &[Vec<Wire>]) -> Result<Vec<usize>, Vec<usize>> {
    let mut done = vec![false; wires.len()];
    let mut order = Vec::with_capacity(wires.len());
    while order.len() < wires.len() {
        let ready = |i: &usize| {
            !done[*i] && wires[*i].iter().flat_map(|w| &w.sources).all(|source| done[source.stage])
        };
        match (0..wires.len()).find(ready) {
            Some(next) => {
                done[next] = true;
                order.push(next);
            }
            None => return Err((0..wires.len()).filter(|i| !done[*i]).collect()),
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stage i takes inputs from the stages listed at i.
    #[track_caller]
    fn check_order(sources: &[&[usize]], expected: Result<&[usize], &[usize]>) {
        let source = |&stage: &usize| WireSource { stage, port: "out".into() };
        let wire = |from: &&[usize]| Wire { port: "in".into(), sources: from.iter().map(source).collect() };
        let wires: Vec<Vec<Wire>> = sources.iter().map(|from| vec![wire(from)]).collect();
        let found = order(&wires);
        assert_eq!(found.as_deref().map_err(Vec::as_slice), expected, "{sources:?}");
    }

    #[test]
    fn stages_follow_their_sources_and_cycles_are_named() {
        check_order(&[], Ok(&[]));
        check_order(&[&[], &[0], &[0, 1]], Ok(&[0, 1, 2]));
        check_order(&[&[2], &[], &[1]], Ok(&[1, 2, 0]));
        check_order(&[&[], &[2], &[1]], Err(&[1, 2]));
        check_order(&[&[0]], Err(&[0]));
    }
}
