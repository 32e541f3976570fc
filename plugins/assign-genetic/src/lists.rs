//! Many short lists of numbers in one piece of memory.

/// Lists of numbers, in order of being added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    items: Vec<u32>,
    ends: Vec<u32>,
}

impl Lists {
    /// How many lists there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// List `k`.
    pub fn get(&self, k: usize) -> &[u32] {
        &self.items[self.range(k)]
    }

    /// Where list `k` is among all numbers.
    pub fn range(&self, k: usize) -> std::ops::Range<usize> {
        let start = if k == 0 { 0 } else { self.ends[k - 1] as usize };
        start..self.ends[k] as usize
    }

    /// Adds a list.
    pub fn push(&mut self, list: impl IntoIterator<Item = u32>) {
        self.items.extend(list);
        self.ends.push(self.items.len() as u32);
    }

    /// The lists in turn.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|k| self.get(k))
    }

    /// All numbers of all lists.
    pub fn items(&self) -> &[u32] {
        &self.items
    }
}
