//! Things by number in groups that grow together: every group is known by the least number in it.

/// For each number one that is no greater and in the same group.
pub struct Heads(Vec<u32>);

impl Heads {
    /// So many groups of one.
    pub fn new(count: usize) -> Heads {
        Heads((0..count as u32).collect())
    }

    /// The least number of a group.
    pub fn of(&self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            number = self.0[number as usize];
        }
        number
    }

    /// Makes one group of two.
    pub fn join(&mut self, one: u32, other: u32) {
        let [one, other] = [one, other].map(|number| self.of(number));
        self.0[one.max(other) as usize] = one.min(other);
    }
}
