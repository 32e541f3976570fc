//! What every camera sees of a choice of markers, and what is wrong with that, kept up to date as markers come and go.
//!
//! With light, everything counts twice: for all markers, and for those bright enough to be seen from afar.
//!
//! All sums are of whole numbers or of multiples of 2⁻⁶ mm, so that the cost does not depend on the way a choice was reached.

use crate::codes::M_SEQUENCE;
use crate::sightlines::Sightlines;
use fibar_core::artefact::sites::Sites;
use glam::{DMat3, DVec3};

/// Markers that a camera should see, not in one plane.
const WANTED: usize = 6;
/// Root mean square distance of the markers from the plane nearest to them above which they are not in one plane, mm: a little
/// more than the tracker asks for, and what makes a good pose.
const THICK_MM: [f64; 2] = [1.3, 4.0];
/// From so many markers on one more changes nothing.
const PLENTY: usize = 32;

/// Costs of one camera, each on the scale of a share of all cameras, in millionths.
struct Prices {
    /// By the number of markers seen: names lost, and short of [`WANTED`].
    seen: [i64; PLENTY + 1],
    /// Too few or thinner than [`THICK_MM`].
    flat: [i64; 2],
    /// By the number of m-sequence markers seen.
    m_sequences: [i64; 3],
}

/// A direction of the watch without an m-sequence marker, beside which all other costs are small.
const BLIND: f64 = 10.0;
/// All markers in the dark.
const DARK: f64 = 0.2;
/// The shortage of a pair without any fibre, which nothing else has.
pub const HOPELESS: f64 = 1.0;
/// A marker is bright up to this shortage: 3 % short of the goal.
const BRIGHT: f64 = 0.001;
/// A further marker beyond its LED's fair share of all.
const CROWDED: f64 = 0.0004;

/// A choice of markers.
#[derive(Clone)]
pub struct Coverage<'a> {
    lines: &'a Sightlines,
    prices: std::sync::Arc<Prices>,
    /// Sites relative to the middle, in multiples of 2⁻⁶ mm.
    spots: std::sync::Arc<Vec<DVec3>>,
    light: Option<std::sync::Arc<SiteLight>>,
    /// The code of each site's marker, from 1.
    carried: Vec<Option<u8>>,
    /// By camera, for all markers and for bright ones.
    survey: Vec<[Tally; 2]>,
    survey_cost: i64,
    /// Sum of shortages, in millionths.
    shortage: i64,
    markers: usize,
    watch: Vec<u32>,
    blind: usize,
    /// Markers by code; the first place stays empty.
    counts: Vec<usize>,
    /// Markers of one code that cost nothing.
    fair_share: usize,
}

/// How well each site can be lit, by what it blinks; and how much that weighs.
pub struct SiteLight {
    /// By site, then by code from 1: shortages.
    pub shortage: Vec<Vec<f64>>,
    /// Beside recognition.
    pub weight: f64,
}

/// What one camera sees.
#[derive(Clone, Copy, Default)]
struct Tally {
    count: usize,
    m_sequences: usize,
    sum: DVec3,
    squares: DVec3,
    /// Sums of yz, zx and xy.
    products: DVec3,
    cost: i64,
}

impl<'a> Coverage<'a> {
    /// No marker anywhere.
    pub fn blank(
        lines: &'a Sightlines,
        sites: &Sites,
        missing_share: f64,
        fair_share: usize,
        light: Option<SiteLight>,
    ) -> Coverage<'a> {
        let spot = |p: DVec3| ((p - sites.centre) * 64.0).round() / 64.0;
        let prices = Prices::new(missing_share);
        let nothing = Tally { cost: prices.of(&Tally::default()), ..Tally::default() };
        Coverage {
            lines,
            spots: sites.sites.iter().map(|s| spot(s.position)).collect::<Vec<_>>().into(),
            carried: vec![None; sites.sites.len()],
            survey_cost: nothing.cost * lines.survey as i64 * if light.is_some() { 2 } else { 1 },
            survey: vec![[nothing; 2]; lines.survey],
            shortage: 0,
            markers: 0,
            light: light.map(std::sync::Arc::new),
            watch: vec![0; lines.watch.len()],
            blind: lines.watch.len(),
            counts: vec![0; usize::from(u8::MAX) + 1],
            fair_share,
            prices: prices.into(),
        }
    }

    /// What a site carries.
    pub fn carried(&self, site: usize) -> Option<u8> {
        self.carried[site]
    }

    /// Whether a site carries a marker that blinks the m-sequence.
    pub fn blinks_m_sequence(&self, site: usize) -> bool {
        self.carried[site] == Some(M_SEQUENCE)
    }

    /// Whether no fibre is known by which this code's LED reaches a site.
    pub fn is_hopeless(&self, site: usize, code: u8) -> bool {
        self.light.as_ref().is_some_and(|light| light.shortage[site][usize::from(code) - 1] >= HOPELESS)
    }

    /// The code other than the m-sequence by which a site gets most light, of equals the first; without light the first.
    pub fn brightest_companion(&self, site: usize) -> u8 {
        let shortage = self.light.as_ref().map_or(&[][..], |light| &light.shortage[site]);
        let companions = (M_SEQUENCE + 1..).zip(shortage.iter().skip(usize::from(M_SEQUENCE)));
        companions.min_by(|a, b| a.1.total_cmp(b.1)).map_or(M_SEQUENCE + 1, |(code, _)| code)
    }

    /// Directions of the watch, by index, without an m-sequence marker.
    pub fn blind_directions(&self) -> Vec<usize> {
        (0..self.watch.len()).filter(|&k| self.watch[k] == 0).collect()
    }

    /// How bad the choice is; 1 is about one camera in a thousand without use.
    pub fn cost(&self) -> f64 {
        let share = |sum: f64, of: usize| sum / of.max(1) as f64;
        let dark = self.light.as_ref().map_or(0.0, |l| l.weight * DARK * self.mean_shortage());
        1e3 * (share(self.survey_cost as f64 * 1e-6, self.lines.survey)
            + BLIND * share(self.blind as f64, self.lines.watch.len())
            + CROWDED * self.beyond_fair_share() as f64
            + dark)
    }

    /// Markers beyond their LED's fair share; without light only the m-sequence counts, as the others have no codes yet.
    fn beyond_fair_share(&self) -> usize {
        let counted = if self.light.is_some() { self.counts.len() } else { usize::from(M_SEQUENCE) + 1 };
        self.counts[..counted].iter().map(|count| count.saturating_sub(self.fair_share)).sum()
    }

    /// Mean shortage of the markers, each with its best code; 0 without light.
    pub fn mean_shortage(&self) -> f64 {
        self.shortage as f64 * 1e-6 / self.markers.max(1) as f64
    }

    /// Changes what a site carries.
    pub fn carry(&mut self, site: usize, code: Option<u8>) {
        let before = std::mem::replace(&mut self.carried[site], code);
        let (had, has) = (self.share_of(site, before), self.share_of(site, code));
        before.iter().for_each(|&code| self.counts[usize::from(code)] -= 1);
        code.iter().for_each(|&code| self.counts[usize::from(code)] += 1);
        self.shortage += has.shortage - had.shortage;
        self.markers = self.markers + has.shown[0] - had.shown[0];
        if (had.shown, had.blinks_m) == (has.shown, has.blinks_m) {
            return;
        }
        let tiers = if self.light.is_some() { 2 } else { 1 };
        for &camera in &self.lines.surveyed_by[site] {
            for (tier, tally) in self.survey[camera as usize][..tiers].iter_mut().enumerate() {
                self.survey_cost -= tally.cost;
                tally.shift(self.spots[site], has.shown[tier] as f64 - had.shown[tier] as f64);
                tally.m_sequences = tally.m_sequences + has.blinks_m[tier] - had.blinks_m[tier];
                tally.cost = self.prices.of(tally);
                self.survey_cost += tally.cost;
            }
        }
        if had.blinks_m[0] != has.blinks_m[0] {
            self.watch_over(site, has.blinks_m[0] == 1);
        }
    }

    /// Counts an m-sequence marker that comes or goes for the directions that watch its site.
    fn watch_over(&mut self, site: usize, comes: bool) {
        for &direction in &self.lines.watched_by[site] {
            let watched = &mut self.watch[direction as usize];
            self.blind -= usize::from(*watched == 0);
            *watched = if comes { *watched + 1 } else { *watched - 1 };
            self.blind += usize::from(*watched == 0);
        }
    }

    /// What a site adds to the tallies when it carries something.
    fn share_of(&self, site: usize, code: Option<u8>) -> Share {
        let Some(code) = code else { return Share::default() };
        let m_sequence = code == M_SEQUENCE;
        let shortage = self.light.as_ref().map_or(0.0, |l| l.shortage[site][usize::from(code) - 1]);
        let shown = [1, usize::from(shortage <= BRIGHT)];
        Share {
            shown,
            blinks_m: if m_sequence { shown } else { [0, 0] },
            shortage: (shortage * 1e6).round() as i64,
        }
    }
}

/// What a marker adds to the tallies, among all markers and among bright ones.
#[derive(Default)]
struct Share {
    shown: [usize; 2],
    blinks_m: [usize; 2],
    shortage: i64,
}

impl Tally {
    /// Adds a marker (`times` 1), takes it away (−1), or nothing (0).
    fn shift(&mut self, spot: DVec3, times: f64) {
        self.count = (self.count as f64 + times) as usize;
        self.sum += spot * times;
        self.squares += spot * spot * times;
        self.products += DVec3::new(spot.y * spot.z, spot.z * spot.x, spot.x * spot.y) * times;
    }

    /// Whether the markers are further than `thickness` from every plane, root mean square, mm: whether their covariance exceeds
    /// its square in all directions (Sylvester's criterion).
    fn is_thicker(&self, thickness: f64) -> bool {
        let n = self.count as f64;
        let mean = self.sum / n;
        let off = self.products / n - DVec3::new(mean.y * mean.z, mean.z * mean.x, mean.x * mean.y);
        let on = self.squares / n - mean * mean - thickness * thickness;
        let matrix = DMat3::from_cols(
            DVec3::new(on.x, off.z, off.y),
            DVec3::new(off.z, on.y, off.x),
            DVec3::new(off.y, off.x, on.z),
        );
        on.x > 0.0 && on.x * on.y > off.z * off.z && matrix.determinant() > 0.0
    }
}

impl Prices {
    fn new(missing_share: f64) -> Prices {
        let short = |n: usize| WANTED.saturating_sub(n) as f64 / WANTED as f64;
        // A missing share half as large again weighs a little too: it tells eight markers from twelve.
        let lost = |n: usize| {
            expected_loss(n, missing_share) + 0.1 * expected_loss(n, (1.5 * missing_share).min(0.9))
        };
        let price = |cost: f64| (cost * 1e6).round() as i64;
        Prices {
            seen: std::array::from_fn(|n| price(0.1 * lost(n) + 0.5 * short(n))),
            flat: [price(0.3), price(0.02)],
            m_sequences: [price(0.5), price(0.1), 0],
        }
    }

    fn of(&self, tally: &Tally) -> i64 {
        let flat = |k: usize| if tally.is_thicker(THICK_MM[k]) { 0 } else { self.flat[k] };
        let flatness = if tally.count < 4 { self.flat[0] + self.flat[1] } else { flat(0) + flat(1) };
        self.seen[tally.count.min(PLENTY)] + flatness + self.m_sequences[tally.m_sequences.min(2)]
    }
}

/// Expected number of blobs without a sure name when each of `n` markers is missing with a probability: those of images with
/// three blobs or fewer, which any pose explains.
fn expected_loss(n: usize, missing: f64) -> f64 {
    /// Share of names lost in images of so many blobs, as measured on held-out views (`docs/recognition.md`).
    const LOST: [f64; 4] = [0.0, 1.0, 1.0, 0.5];
    let blobs = |k: usize| {
        let ways = (0..k).fold(1.0, |ways, i| ways * (n - i) as f64 / (i + 1) as f64);
        ways * libm::pow(1.0 - missing, k as f64) * libm::pow(missing, (n - k) as f64)
    };
    (1..=n.min(3)).map(|k| blobs(k) * k as f64 * LOST[k]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ball, params, sites};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_cost_does_not_depend_on_the_way() {
        let (sites, params) = (sites(4), params(|_| ()));
        let lines = Sightlines::cast(&ball(), &sites, &params);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let dim = |k: usize| vec![(k % 3) as f64 * 0.4, (k % 5) as f64 * 0.2, (k % 2) as f64 * 0.5];
        let light = || SiteLight { shortage: (0..sites.sites.len()).map(dim).collect(), weight: 1.0 };
        let mut walked = Coverage::blank(&lines, &sites, 0.3, 5, Some(light()));
        let codes = [None, Some(1), Some(2), Some(3)];
        for _ in 0..2000 {
            walked.carry(rng.random_range(0..sites.sites.len()), codes[rng.random_range(0..4)]);
        }
        let mut straight = Coverage::blank(&lines, &sites, 0.3, 5, Some(light()));
        (0..sites.sites.len()).for_each(|k| straight.carry(k, walked.carried(k)));
        assert_eq!(straight.cost(), walked.cost());
        assert_eq!(straight.blind_directions(), walked.blind_directions());
    }

    #[test]
    fn thickness_is_the_distance_from_the_nearest_plane() {
        let check = |points: &[[f64; 3]], thickness: f64| {
            let mut tally = Tally::default();
            points.iter().for_each(|p| tally.shift(DVec3::from(*p), 1.0));
            assert!(tally.is_thicker(thickness - 1e-6), "{points:?} is thinner than {thickness}");
            assert!(!tally.is_thicker(thickness + 1e-6), "{points:?} is thicker than {thickness}");
        };
        let square = [[10.0, 10.0, 0.0], [10.0, -10.0, 0.0], [-10.0, 10.0, 0.0], [-10.0, -10.0, 0.0]];
        check(&[square, square.map(|[x, y, _]| [x, y, 4.0])].concat(), 2.0);
        check(
            &[
                [2.0, 0.0, 0.0],
                [-2.0, 0.0, 0.0],
                [0.0, 9.0, 0.0],
                [0.0, -9.0, 0.0],
                [0.0, 0.0, 9.0],
                [0.0, 0.0, -9.0],
            ],
            (8.0f64 / 6.0).sqrt(),
        );
        let mut flat = Tally::default();
        square.iter().for_each(|p| flat.shift(DVec3::from(*p), 1.0));
        assert!(!flat.is_thicker(0.01));
    }

    #[test]
    fn lost_names_are_those_of_images_with_three_blobs_or_fewer() {
        let check = |n, missing, expected: f64| {
            let found = expected_loss(n, missing);
            assert!((found - expected).abs() < 1e-12, "{n} {missing}: {found}");
        };
        check(0, 0.3, 0.0);
        check(3, 0.0, 1.5);
        check(4, 0.0, 0.0);
        // One of four is missing: 4 · 0.5⁴ ways to three blobs; two: 6; three: 4.
        check(4, 0.5, (4.0 * 1.5 + 6.0 * 2.0 + 4.0) / 16.0);
    }
}
