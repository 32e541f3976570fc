//! The table, and what it comes to.

use super::outcome::Outcome;
use super::{Row, TOOLS};
use std::cmp::Ordering;

/// Prints a row for each mesh, then a line for each tool, then where ours falls short.
pub fn print(rows: &[Row]) {
    let peers: Vec<&str> = TOOLS[1..].iter().map(|(name, _)| *name).collect();
    println!("| mesh | what | repair-manifold | volume | moved, mm | s | {} |", peers.join(" | "));
    println!("|{}", " --- |".repeat(6 + peers.len()));
    for row in rows {
        let ours = &row.outcomes[0];
        let cells: Vec<String> = row.outcomes[1..].iter().map(cell).collect();
        println!(
            "| {} | {} | {} | {} | {} | {} | {} |",
            row.patient.name,
            row.patient.what,
            ours.wrong.as_deref().unwrap_or("repaired"),
            ours.volume_off.map_or("unknown".into(), |off| format!("{:+.3} %", 100.0 * off)),
            ours.displacement.map_or(String::new(), |moved| format!("{moved:.4}")),
            ours.seconds.map_or(String::new(), seconds),
            cells.join(" | ")
        );
    }
    println!();
    print_sums(rows);
    print_shortfalls(rows);
}

fn seconds(time: f64) -> String {
    if time < 0.1 { format!("{time:.4}") } else { format!("{time:.2}") }
}

fn cell(outcome: &Outcome) -> String {
    match (&outcome.wrong, outcome.seconds) {
        (None, Some(time)) => format!("repaired, {}", seconds(time)),
        (Some(wrong), _) => wrong.clone(),
        (None, None) => String::new(),
    }
}

fn print_sums(rows: &[Row]) {
    println!("| tool | right, of {} | right and fastest |", rows.len());
    println!("| --- | --- | --- |");
    let fastest: Vec<Option<usize>> = rows.iter().map(|row| fastest(row, 0)).collect();
    for (number, (name, _)) in TOOLS.iter().enumerate() {
        let right = rows.iter().filter(|row| row.outcomes[number].wrong.is_none()).count();
        let first = fastest.iter().filter(|tool| **tool == Some(number)).count();
        println!("| {name} | {right} | {first} |");
    }
    println!();
}

/// The fastest tool that got a mesh right, of those from a column on.
fn fastest(row: &Row, from: usize) -> Option<usize> {
    let right = (from..TOOLS.len()).filter(|&tool| row.outcomes[tool].wrong.is_none());
    right.min_by(|&a, &b| row.outcomes[a].compare(&row.outcomes[b]).then(Ordering::Less))
}

fn print_shortfalls(rows: &[Row]) {
    for row in rows {
        let (ours, name) = (&row.outcomes[0], &row.patient.name);
        let peer = fastest(row, 1).map(|tool| (TOOLS[tool].0, row.outcomes[tool].seconds.unwrap_or(0.0)));
        match (ours.wrong.as_deref(), ours.seconds, peer) {
            (Some(wrong), _, Some((peer, _))) => println!("- lost: {name}: {wrong}; {peer} repairs it"),
            (Some(wrong), _, None) => println!("- nobody repairs {name}; ours: {wrong}"),
            (None, Some(time), Some((peer, other))) if time > other => {
                println!(
                    "- slower: {name}: {} s, {peer} {} s ({:.1} times)",
                    seconds(time),
                    seconds(other),
                    time / other
                );
            }
            _ => {}
        }
    }
}
