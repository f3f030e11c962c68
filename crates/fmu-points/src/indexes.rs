//! Sets of points.

/// A set of indexes, a bit each.
#[derive(Clone, Debug, Default)]
pub struct Indexes(Vec<u64>);

impl Indexes {
    pub(crate) fn set(&mut self, index: u64, present: bool) {
        let place = usize::try_from(index / 64).unwrap_or(usize::MAX);
        if place >= self.0.len() {
            if !present {
                return;
            }
            self.0.resize(place + 1, 0);
        }
        let bit = 1 << (index % 64);
        if present {
            self.0[place] |= bit;
        } else {
            self.0[place] &= !bit;
        }
    }

    /// Whether an index is in it.
    pub fn has(&self, index: u64) -> bool {
        let word = usize::try_from(index / 64).ok();
        let word = word.and_then(|place| self.0.get(place));
        word.is_some_and(|word| word >> (index % 64) & 1 == 1)
    }

    /// Adds an index.
    pub fn insert(&mut self, index: u64) {
        self.set(index, true);
    }

    /// Takes an index away.
    pub fn remove(&mut self, index: u64) {
        self.set(index, false);
    }

    /// Takes all of another set.
    pub(crate) fn take(&mut self, other: &mut Self) {
        self.0.resize(self.0.len().max(other.0.len()), 0);
        for (own, other) in self.0.iter_mut().zip(other.0.drain(..)) {
            *own |= other;
        }
    }

    /// Its indexes in their order.
    pub fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        let words = self.0.iter().zip(0_u64..);
        words.flat_map(|(word, place)| {
            (0..64)
                .filter(move |bit| word >> bit & 1 == 1)
                .map(move |bit| 64 * place + bit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_indexes() {
        let mut set = Indexes::default();
        for index in [0, 63, 64, 1000] {
            set.insert(index);
        }
        set.remove(63);
        set.remove(100_000);
        let mut other = Indexes::default();
        other.insert(70_000);
        set.take(&mut other);
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 64, 1000, 70_000]);
        assert_eq!(other.iter().count(), 0);
    }
}
