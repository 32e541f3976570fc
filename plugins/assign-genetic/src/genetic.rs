//! The genetic algorithm: a small elitist population, offspring by mutation and by exchange of regions.
//!
//! The paper fixes the chromosome, the objective and the stopping rule; the rest is ours (`docs/assign-genetic.md`).
//! Random numbers are drawn by one thread, chromosomes are evaluated by all.

use crate::objective::{Evaluated, Rules};
use crate::params::Params;
use fibar_core::images::Images;
use rand::RngExt;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// What the search found.
pub struct Found {
    /// The best chromosome.
    pub best: Evaluated,
    /// Best objective after each iteration, the initial population's first.
    pub history: Vec<f64>,
}

/// Searches the assignment of `patterns` patterns until `stop_after` iterations bring no gain. `progress` gets the
/// iterations done and the best objective, and may end the search with its error.
pub fn search<E>(
    images: &Images,
    patterns: u8,
    params: &Params,
    seed: u64,
    mut progress: impl FnMut(usize, f64) -> Result<(), E>,
) -> Result<Found, E> {
    let rules = Rules::new(params.k1, params.k2);
    let mut breeder = Breeder { images, patterns, params, rng: ChaCha8Rng::seed_from_u64(seed) };
    let mut population = breeder.found_population(&rules);
    let mut history = vec![population[0].objective];
    let mut stale = 0;
    while stale < params.stop_after && history.len() <= params.most_iterations as usize {
        let best = population[0].objective;
        progress(history.len() - 1, best)?;
        let offspring = evaluate(breeder.plan_offspring(&population), images, &rules);
        population = survivors(population, offspring, params.population as usize);
        stale = if population[0].objective > best { 0 } else { stale + 1 };
        history.push(population[0].objective);
    }
    Ok(Found { best: population.swap_remove(0), history })
}

/// A chromosome to evaluate, and the evaluated one it is a change of.
type Offspring<'a> = (&'a Evaluated, Vec<u8>);

fn evaluate(offspring: Vec<Offspring>, images: &Images, rules: &Rules) -> Vec<Evaluated> {
    offspring.into_par_iter().map(|(parent, genes)| parent.changed_to(genes, images, rules)).collect()
}

/// The best of old and new without repetitions, best first; of equals the older.
fn survivors(mut all: Vec<Evaluated>, offspring: Vec<Evaluated>, count: usize) -> Vec<Evaluated> {
    for child in offspring {
        if all.iter().all(|other| other.objective != child.objective || other.genes != child.genes) {
            all.push(child);
        }
    }
    all.sort_by(|a, b| b.objective.total_cmp(&a.objective));
    all.truncate(count);
    all
}

/// Makes chromosomes.
struct Breeder<'a> {
    images: &'a Images,
    patterns: u8,
    params: &'a Params,
    rng: ChaCha8Rng,
}

impl Breeder<'_> {
    /// Chromosomes with a marker at every site and patterns at random, best first.
    fn found_population(&mut self, rules: &Rules) -> Vec<Evaluated> {
        let count = self.images.sites.len();
        // All share one topology, which the first brings.
        let first = Evaluated::blank(self.images).changed_to(vec![1; count], self.images, rules);
        let founders: Vec<Offspring> = (0..self.params.population)
            .map(|_| (&first, (0..count).map(|_| self.rng.random_range(1..=self.patterns)).collect()))
            .collect();
        survivors(Vec::new(), evaluate(founders, self.images, rules), self.params.population as usize)
    }

    fn plan_offspring<'a>(&mut self, population: &'a [Evaluated]) -> Vec<Offspring<'a>> {
        let count = self.params.offspring;
        let plan = |_| {
            let parent = self.choose_parent(population);
            let mut genes = parent.genes.clone();
            if self.rng.random::<f64>() < self.params.crossover_share {
                let donor = self.choose_parent(population);
                self.take_region(&mut genes, &donor.genes);
            }
            self.mutate(&mut genes);
            (parent, genes)
        };
        (0..count).map(plan).collect()
    }

    /// The better of two at random.
    fn choose_parent<'a>(&mut self, population: &'a [Evaluated]) -> &'a Evaluated {
        let count = population.len();
        // The population is in order: the lesser index is the better chromosome.
        &population[self.rng.random_range(0..count).min(self.rng.random_range(0..count))]
    }

    /// Copies the genes of a site and of those nearest to it, up to half of all, from a donor. What a marker's pattern is
    /// good for depends on its neighbours', so neighbours stay together.
    fn take_region(&mut self, genes: &mut [u8], donor: &[u8]) {
        let sites = &self.images.sites;
        let Some(centre) = sites.choose(&mut self.rng).map(|s| s.position) else { return };
        let mut order: Vec<usize> = (0..sites.len()).collect();
        order.sort_by_cached_key(|&k| Metric(sites[k].position.distance_squared(centre)));
        let size = self.rng.random_range(1..=sites.len().div_ceil(2));
        order[..size].iter().for_each(|&k| genes[k] = donor[k]);
    }

    /// Changes each gene with the chance of `mutation_rate`, one at least.
    fn mutate(&mut self, genes: &mut [u8]) {
        let certain = self.rng.random_range(0..genes.len());
        for (k, gene) in genes.iter_mut().enumerate() {
            if k == certain || self.rng.random::<f64>() < self.params.mutation_rate {
                *gene = self.another_pattern(*gene);
            }
        }
    }

    /// Another pattern, or with the chance of `drop_share` none.
    fn another_pattern(&mut self, pattern: u8) -> u8 {
        if pattern == 0 || self.patterns == 1 {
            return if pattern == 0 { self.rng.random_range(1..=self.patterns) } else { 0 };
        }
        if self.rng.random::<f64>() < self.params.drop_share {
            return 0;
        }
        let other = self.rng.random_range(1..self.patterns);
        if other < pattern { other } else { other + 1 }
    }
}

/// A squared distance as a sorting key.
#[derive(PartialEq)]
struct Metric(f64);

impl Eq for Metric {}

impl PartialOrd for Metric {
    fn partial_cmp(&self, other: &Metric) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Metric {
    fn cmp(&self, other: &Metric) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
