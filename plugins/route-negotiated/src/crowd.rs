//! Axes of fibres as straight segments in cells of space: which of them are near a segment.

use fibar_geometry::course::nodes::Node;
use fibar_geometry::segments::approach;
use glam::{DVec3, IVec3};

/// A piece of an axis between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Both ends, mm.
    pub ends: [DVec3; 2],
    /// What its fibre carries.
    pub pattern: u32,
    middle: DVec3,
    /// Half its length and its fibre's margin, mm.
    reach: f64,
    margin: f64,
}

/// What two segments that are too close cost.
pub struct Push {
    /// The cost.
    pub cost: f64,
    /// Its derivatives by the ends of the first segment and of the second.
    pub slopes: [[DVec3; 2]; 2],
}

impl Segment {
    /// The segments of an axis through these nodes; `margin` mm are added to the distance that it keeps.
    pub fn along(nodes: &[Node], pattern: u32, margin: f64) -> impl Iterator<Item = Segment> {
        nodes.windows(2).map(move |w| {
            let ends = [w[0].position, w[1].position];
            let reach = 0.5 * ends[0].distance(ends[1]) + margin;
            Segment { ends, pattern, middle: ends[0].midpoint(ends[1]), reach, margin }
        })
    }

    /// Whether the other might be within `distance` mm and both margins.
    #[inline]
    pub fn may_touch(&self, other: &Segment, distance: f64) -> bool {
        let reach = distance + self.reach + other.reach;
        self.middle.distance_squared(other.middle) < reach * reach
    }

    /// What it costs that the other is closer than `distance` and both margins: the square of what lacks, by the length.
    pub fn push(&self, other: &Segment, distance: f64, weight: f64) -> Option<Push> {
        let distance = distance + self.margin + other.margin;
        let found = approach(self.ends, other.ends);
        let square = found.arm.length_squared();
        if square >= distance * distance {
            return None;
        }
        let between = square.sqrt();
        let lack = distance - between;
        let length = 2.0 * ((self.reach - self.margin) * (other.reach - other.margin)).sqrt();
        let slope = -2.0 * weight * length * lack * found.arm / between.max(1e-6);
        let slopes =
            [[(1.0 - found.s) * slope, found.s * slope], [(found.t - 1.0) * slope, -found.t * slope]];
        Some(Push { cost: weight * length * lack * lack, slopes })
    }
}

/// The axes of several fibres, their segments sorted into cells by their middles.
pub struct Crowd {
    low: DVec3,
    counts: IVec3,
    /// Fibre and segment.
    cells: Vec<Vec<[u32; 2]>>,
    fibres: Vec<Vec<Segment>>,
}

/// Side of a cell, mm.
const CELL_MM: f64 = 5.0;

impl Crowd {
    /// No fibre yet, in a body with these least and greatest coordinates; what is outside goes to the cells at the border.
    pub fn within((low, high): (DVec3, DVec3)) -> Crowd {
        let counts = ((high - low) / CELL_MM).ceil().as_ivec3().clamp(IVec3::ONE, IVec3::splat(256));
        Crowd { low, counts, cells: vec![vec![]; counts.element_product() as usize], fibres: vec![] }
    }

    /// Forgets all fibres.
    pub fn clear(&mut self) {
        for segment in std::mem::take(&mut self.fibres).iter().flatten() {
            let cell = number(self.counts, self.cell(segment.middle));
            self.cells[cell].clear();
        }
    }

    /// Adds a fibre.
    pub fn push(&mut self, segments: Vec<Segment>) {
        self.fibres.push(vec![]);
        self.replace(self.fibres.len() - 1, segments);
    }

    /// Moves a fibre.
    pub fn replace(&mut self, fibre: usize, segments: Vec<Segment>) {
        for segment in std::mem::take(&mut self.fibres[fibre]) {
            let cell = number(self.counts, self.cell(segment.middle));
            self.cells[cell].retain(|[k, _]| *k as usize != fibre);
        }
        for (k, segment) in segments.iter().enumerate() {
            let cell = number(self.counts, self.cell(segment.middle));
            self.cells[cell].push([fibre as u32, k as u32]);
        }
        self.fibres[fibre] = segments;
    }

    /// Calls with the fibre and the number of every segment of other patterns that might be within `distance` mm of one.
    pub fn for_each_near(&self, segment: &Segment, distance: f64, mut each: impl FnMut([u32; 2], &Segment)) {
        const LONGEST_HALF_MM: f64 = 2.5; // longer segments are missed until they are near; none is in a settled axis
        let reach = DVec3::splat(distance + segment.reach + LONGEST_HALF_MM);
        let (low, high) = (self.cell(segment.middle - reach), self.cell(segment.middle + reach));
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    for &[fibre, k] in &self.cells[number(self.counts, IVec3::new(x, y, z))] {
                        let other = &self.fibres[fibre as usize][k as usize];
                        if other.pattern != segment.pattern && segment.may_touch(other, distance) {
                            each([fibre, k], other);
                        }
                    }
                }
            }
        }
    }

    /// A segment of a fibre.
    #[inline]
    pub fn segment(&self, [fibre, k]: [u32; 2]) -> &Segment {
        &self.fibres[fibre as usize][k as usize]
    }

    fn cell(&self, place: DVec3) -> IVec3 {
        let at = ((place - self.low) / CELL_MM).clamp(DVec3::ZERO, DVec3::splat(1e6));
        at.as_ivec3().min(self.counts - IVec3::ONE)
    }
}

fn number(counts: IVec3, cell: IVec3) -> usize {
    ((cell.z * counts.y + cell.y) * counts.x + cell.x) as usize
}
