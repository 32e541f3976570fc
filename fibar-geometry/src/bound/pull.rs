//! What the tangent's way over the sphere costs at least while a force of one strength pulls, for fibres of one length.

use crate::optics::Absorption;
use glam::DVec2;
use std::f64::consts::PI;

/// Cells of the angle between tangent and force, 0 to π.
const CELLS: usize = 120;
/// Slacks δ that are tried, relative to c1.
const SLACKS: [f64; 8] = [0.0, 0.02, 0.06, 0.12, 0.22, 0.38, 0.6, 1.0];
/// Beyond this angle to the force a way passes round the back.
const ROUND_THE_BACK: f64 = 0.7 * PI;

/// What a radian costs at least where a millimetre of it costs `x` more than one of a straight fibre at its best:
/// `g(x) = min over κ ≤ κmax of (a(κ) − c1 + x)/κ`, from below. As a least of lines it is concave, so chords lie below it.
pub struct Radian {
    most: f64,
    nodes: Vec<f64>,
}

impl Radian {
    const NODES: usize = 300;

    /// Tables `g` up to `most`, 1/mm.
    pub fn new(absorption: &Absorption, min_bend_radius: f64, most: f64) -> Radian {
        let c1 = absorption.law().c1_per_mm;
        let node = |k: usize| cheapest_radian(absorption, 1.0 / min_bend_radius, c1 - Self::place(k) * most);
        Radian { most, nodes: (0..=Self::NODES).map(node).collect() }
    }

    /// Nodes lie close where `g` is steep.
    fn place(k: usize) -> f64 {
        let share = k as f64 / Self::NODES as f64;
        share * share * share
    }

    fn at(&self, x: f64) -> f64 {
        let share = (x / self.most).clamp(0.0, 1.0);
        let k = ((libm::cbrt(share) * Self::NODES as f64) as usize).min(Self::NODES - 1);
        let (below, above) = (Self::place(k), Self::place(k + 1));
        let t = ((share - below) / (above - below)).clamp(0.0, 1.0);
        self.nodes[k] + t * (self.nodes[k + 1] - self.nodes[k])
    }
}

/// `min over κ ≤ most of (a(κ) − gain)/κ`, from below: between two curvatures the lesser numerator over the larger κ.
fn cheapest_radian(absorption: &Absorption, most: f64, gain: f64) -> f64 {
    const RATIO: f64 = 0.995;
    const STEPS: u32 = 1200;
    let (mut above, mut least) = (most, f64::INFINITY);
    for _ in 0..STEPS {
        let below = above * RATIO;
        least = least.min((absorption.per_mm(below) - gain).max(0.0) / above);
        above = below;
    }
    least.min((absorption.law().c1_per_mm - gain).max(0.0) / above)
}

/// A force of one strength, its direction still open.
pub struct Pull {
    /// |λ|, 1/mm.
    pub strength: f64,
    c1: f64,
    /// By nearest cell and slack.
    levels: Vec<Level>,
}

/// Tangents that come no nearer to the force than the lower border of one cell; one slack.
struct Level {
    /// `∫w` from the level's border to the lower border of each cell; 0 below.
    sum: Vec<f64>,
    /// Least cost of a radian around the force between the level's border and the upper border of each cell.
    ring: Vec<f64>,
    /// Least cost of any radian.
    least: f64,
}

/// How the tangent starts and ends, seen from the force, rad.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Angle to the force at the start.
    pub from: f64,
    /// Least and greatest angle at the end.
    pub to: (f64, f64),
    /// Angle around the force between start and end, at least.
    pub around: f64,
    /// Angle between start and end, at least.
    pub between: f64,
}

impl Pull {
    /// Prepares the tables.
    pub fn new(absorption: &Absorption, radian: &Radian, share: f64) -> Pull {
        let c1 = absorption.law().c1_per_mm;
        let strength = share * c1;
        let borders: Vec<DVec2> = (0..=CELLS).map(|k| DVec2::from(libm::sincos(border(k)))).collect();
        let level = |nearest: usize, slack: f64| Level::new(radian, strength, &borders, nearest, slack * c1);
        let levels = (0..CELLS).flat_map(|nearest| SLACKS.map(|slack| level(nearest, slack)));
        Pull { strength, c1, levels: levels.collect() }
    }

    /// `∫(a − λ·t) ds` of any fibre whose tangent turns so and whose length lies between two, mm, at least; and the cell where that
    /// is least, a good `guess` for the next. −∞ as soon as it is known not to exceed `floor`.
    pub fn least(&self, turn: &Turn, lengths: [f64; 2], guess: usize, floor: f64) -> (f64, usize) {
        let spots = Spots::of(turn);
        let last = spots.from.cell.min(spots.to.1.cell);
        let (mut least, mut place) = (f64::INFINITY, 0);
        for nearest in std::iter::once(guess.min(last)).chain(0..=last) {
            let value = self.least_at(nearest, turn, &spots, lengths);
            if value < least {
                (least, place) = (value, nearest);
            }
            if least <= floor {
                return (f64::NEG_INFINITY, place);
            }
        }
        (least, place)
    }

    /// The same for ways that come as near to the force as one cell, but no nearer. For one slack it is linear in the length,
    /// so between two lengths it is no less than the lesser of theirs.
    fn least_at(&self, nearest: usize, turn: &Turn, spots: &Spots, lengths: [f64; 2]) -> f64 {
        let straight = self.c1 - self.strength * libm::cos(border(nearest));
        let levels = &self.levels[nearest * SLACKS.len()..][..SLACKS.len()];
        levels.iter().zip(SLACKS).fold(f64::NEG_INFINITY, |best, (level, slack)| {
            let turning = level.turning(nearest, turn, spots);
            let [shorter, longer] = lengths.map(|length| (straight - slack * self.c1) * length);
            best.max(shorter.min(longer) + turning)
        })
    }
}

impl Level {
    /// `borders` are sine and cosine of the cells' borders.
    fn new(radian: &Radian, strength: f64, borders: &[DVec2], nearest: usize, slack: f64) -> Level {
        let (mut sum, mut ring) = (vec![0.0; CELLS + 1], vec![f64::INFINITY; CELLS]);
        let mut least = f64::INFINITY;
        for k in nearest..CELLS {
            let dearer = strength * (borders[nearest].y - borders[k].y);
            let weight = radian.at(slack + dearer);
            sum[k + 1] = sum[k] + weight * border(1);
            let sine = borders[k].x.min(borders[k + 1].x).max(0.0);
            least = least.min(weight * sine);
            ring[k] = least;
        }
        Level { sum, ring, least: radian.at(slack) }
    }

    /// `∫w|dt|` of a way that comes as near to the force as this cell, but no nearer: the greatest of what is known.
    ///
    /// Its part towards the force and back costs at least `∫w` over those angles, its part around the force at least the ring;
    /// both together the hypotenuse, as `|∫v| ≤ ∫|v|`. A way may also pass round the back, there and back. And every
    /// radian costs at least the least, however it turns; those towards the force cost more.
    fn turning(&self, nearest: usize, turn: &Turn, spots: &Spots) -> f64 {
        let reached = self.sum[nearest + 1];
        let [from, near, last, far] =
            [&spots.from, &spots.to.0, &spots.to.1, &spots.far].map(|s| self.sum_to(s));
        let radial = (from - reached).max(0.0) + (near - reached).max(0.0);
        let angle = |angle: f64| (angle - border(nearest + 1)).max(0.0);
        let towards = angle(turn.from) + angle(turn.to.0);
        let even = self.least * turn.between.max(towards) + radial - self.least * towards;
        let front = libm::hypot(radial, self.ring[spots.far.cell] * turn.around);
        even.max(front.min(2.0 * far - from - last))
    }

    /// `∫w` to an angle.
    fn sum_to(&self, spot: &Spot) -> f64 {
        let below = self.sum[spot.cell];
        below + spot.share * (self.sum[spot.cell + 1] - below)
    }
}

/// The angles of a turn, as places in the tables.
struct Spots {
    from: Spot,
    to: (Spot, Spot),
    far: Spot,
}

/// A place in the tables: a cell, and where in it, 0 to 1.
struct Spot {
    cell: usize,
    share: f64,
}

impl Spots {
    fn of(turn: &Turn) -> Spots {
        let far = ROUND_THE_BACK.max(turn.from).max(turn.to.1);
        let to = (Spot::of(turn.to.0), Spot::of(turn.to.1));
        Spots { from: Spot::of(turn.from), to, far: Spot::of(far) }
    }
}

impl Spot {
    fn of(angle: f64) -> Spot {
        let cell = ((angle / PI * CELLS as f64) as usize).min(CELLS - 1);
        Spot { cell, share: (angle - border(cell)) / border(1) }
    }
}

/// Lower border of a cell, rad.
fn border(cell: usize) -> f64 {
    PI * cell as f64 / CELLS as f64
}
