//! How much of the machine a build may use.

use fibar_core::protocol::Resources;

/// Cores and memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// At least 1.
    pub cores: u32,
    /// MB.
    pub memory_mb: u64,
}

impl Budget {
    /// All cores and most of the memory.
    pub fn whole_machine() -> Budget {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
        Budget { cores, memory_mb: crate::os::memory_mb() * 8 / 10 }
    }

    /// As many cores as said, and most of the memory.
    pub fn cores(cores: u32) -> Budget {
        Budget { cores: cores.max(1), ..Budget::whole_machine() }
    }
}

/// What is left of a budget while stages run.
#[derive(Debug)]
pub(super) struct Free {
    total: Budget,
    cores: u32,
    memory_mb: u64,
    running: u32,
}

/// What a running stage holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grant {
    pub cores: u32,
    memory_mb: u64,
}

impl Free {
    pub fn new(total: Budget) -> Free {
        Free { total, cores: total.cores, memory_mb: total.memory_mb, running: 0 }
    }

    /// A share for a stage when `waiting` stages, itself included, could start now. A stage that wants more than the
    /// whole budget gets all of it, alone.
    pub fn take(&mut self, wish: &Resources, waiting: usize) -> Option<Grant> {
        let least = wish.min_cores.clamp(1, self.total.cores);
        let memory_mb = u64::from(wish.memory_mb).min(self.total.memory_mb);
        if self.running > 0 && (self.cores < least || self.memory_mb < memory_mb) {
            return None;
        }
        let most = if wish.max_cores == 0 { self.total.cores } else { wish.max_cores.max(least) };
        let share = self.cores / waiting.max(1) as u32;
        let cores = share.clamp(least, most.max(least)).min(self.cores.max(1));
        self.cores = self.cores.saturating_sub(cores);
        self.memory_mb = self.memory_mb.saturating_sub(memory_mb);
        self.running += 1;
        Some(Grant { cores, memory_mb })
    }

    /// Whether nothing more can start.
    pub fn is_used_up(&self) -> bool {
        self.running > 0 && (self.cores == 0 || self.memory_mb == 0)
    }

    pub fn give_back(&mut self, grant: Grant) {
        self.cores += grant.cores;
        self.memory_mb += grant.memory_mb;
        self.running -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wishes are (min cores, max cores, MB); the answer is the cores granted to each, 0 for "wait".
    #[track_caller]
    fn check(wishes: &[(u32, u32, u32)], expected: &[u32]) {
        let mut free = Free::new(Budget { cores: 4, memory_mb: 1000 });
        let grants = wishes.iter().enumerate().map(|(i, &(min_cores, max_cores, memory_mb))| {
            let wish = Resources { min_cores, max_cores, memory_mb };
            free.take(&wish, wishes.len() - i).map_or(0, |grant| grant.cores)
        });
        assert_eq!(grants.collect::<Vec<_>>(), expected, "{wishes:?}");
    }

    #[test]
    fn cores_and_memory_are_shared_and_never_oversold() {
        check(&[(1, 0, 100)], &[4]);
        check(&[(1, 0, 100), (1, 0, 100)], &[2, 2]);
        check(&[(1, 1, 100), (1, 0, 100)], &[1, 3]);
        check(&[(9, 0, 100)], &[4]);
        check(&[(1, 1, 9000), (1, 1, 100)], &[1, 0]);
        check(&[(1, 1, 600), (1, 1, 600), (1, 1, 300)], &[1, 0, 1]);
        check(&[(1, 0, 1); 6], &[1, 1, 1, 1, 0, 0]);
    }
}
