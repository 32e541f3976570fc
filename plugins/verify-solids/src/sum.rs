//! Lengths added up along lines, and the longest of each kind.

use glam::DVec3;

/// A stretch of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// How long it is, mm.
    pub length: f64,
    /// Its middle, mm.
    pub place: DVec3,
}

/// All stretches of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Total {
    /// Sum of their lengths, mm; after [`Sums::times`] a volume, mm³.
    pub length: f64,
    /// The longest.
    pub longest: Spot,
    /// Between which solids the longest is.
    pub between: Option<(usize, usize)>,
}

/// What the lines found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Inside two solids.
    pub overlap: Total,
    /// Inside the object and outside every hole and solid.
    pub gap: Total,
    /// Inside a solid and outside the object.
    pub outside: Total,
    /// Lines that went too close to a corner to be told.
    pub skipped_lines: usize,
}

impl Total {
    /// Counts one more stretch.
    pub fn add(&mut self, spot: Spot, between: Option<(usize, usize)>) {
        let other = Total { length: spot.length, longest: spot, between };
        *self = self.and(other);
    }

    fn and(self, other: Total) -> Total {
        let longer = if other.longest.length > self.longest.length { other } else { self };
        Total { length: self.length + other.length, ..longer }
    }

    fn times(self, area: f64) -> Total {
        Total { length: self.length * area, ..self }
    }
}

impl Sums {
    /// Both together.
    pub fn and(self, other: Sums) -> Sums {
        Sums {
            overlap: self.overlap.and(other.overlap),
            gap: self.gap.and(other.gap),
            outside: self.outside.and(other.outside),
            skipped_lines: self.skipped_lines + other.skipped_lines,
        }
    }

    /// Volumes from lengths, by the area that each line stands for, mm².
    pub fn times(self, area: f64) -> Sums {
        Sums {
            overlap: self.overlap.times(area),
            gap: self.gap.times(area),
            outside: self.outside.times(area),
            ..self
        }
    }
}
