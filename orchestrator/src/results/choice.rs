//! Some rows of a long table: the best ones, and an even choice by chance of all.

use std::collections::BTreeMap;

use sampling::random::mix;

/// The most rows that a page is made of: more would only take memory, which no plot shows.
pub const MOST: u64 = 500_000;

/// The number of best rows that are kept in any case.
const BEST: usize = 1000;

/// An even choice of rows: one of each block of rows, by a chance that is the same every time. Every 20th row, say,
/// would not do: of a Sobol sequence, such rows fill a part of the space only.
#[derive(Clone, Copy)]
pub struct Even {
    block: u64,
}

impl Even {
    /// At most `most` of `rows` rows.
    pub fn new(rows: u64, most: u64) -> Self {
        Self { block: rows.div_ceil(most.max(1)).max(1) }
    }

    /// Whether it leaves out any row.
    pub fn is_whole(self) -> bool {
        self.block == 1
    }

    /// Whether a row is chosen.
    pub fn has(self, row: u64) -> bool {
        // Successive numbers are alike: SplitMix64 spreads them so.
        let spread = (row / self.block).wrapping_add(0x9e37_79b9_7f4a_7c15);
        row % self.block == mix(spread) % self.block
    }
}

/// The best rows so far that were not chosen otherwise.
#[derive(Default)]
pub struct Best {
    /// By how good they are, the best first: not verified, the bits of the distance, which grow as it does, the number.
    rows: BTreeMap<(bool, u64, u64), csv::StringRecord>,
}

impl Best {
    /// Offers a row; `distance` is how far it is from the measurement, 0 or more.
    pub fn offer(&mut self, row: u64, verified: bool, distance: f64, record: &csv::StringRecord) {
        let place = (!verified, distance.to_bits(), row);
        if self.rows.len() == BEST {
            if self.rows.last_key_value().is_none_or(|(worst, _)| *worst < place) {
                return;
            }
            self.rows.pop_last();
        }
        self.rows.insert(place, record.clone());
    }

    /// The best rows with their numbers, in the order of the table.
    pub fn into_rows(self) -> Vec<(u64, csv::StringRecord)> {
        let mut rows: Vec<_> = self.rows.into_iter().map(|((.., row), record)| (row, record)).collect();
        rows.sort_unstable_by_key(|(row, _)| *row);
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_choice_has_one_row_of_each_block() {
        let even = Even::new(10_000_000, MOST);
        assert!(!even.is_whole());
        let chosen: Vec<u64> = (0..10_000_000).filter(|&row| even.has(row)).collect();
        assert_eq!(chosen.len() as u64, MOST);
        assert!(chosen.iter().zip(0..).all(|(row, block)| row / 20 == block));
        // By chance, and evenly so: 500,000 rows in 20 places, each with its share within five deviations.
        let mut places = [0_i32; 20];
        chosen.iter().for_each(|row| places[(row % 20) as usize] += 1);
        let all_near = places.iter().all(|count| (count - 25_000).abs() < 5 * 155);
        assert!(all_near, "{places:?}");
        assert!(Even::new(MOST, MOST).is_whole());
        assert!((0..100).all(|row| Even::new(7, 100).has(row)));
    }

    #[test]
    fn the_best_rows_are_kept() {
        let mut best = Best::default();
        let record = |row: u64| csv::StringRecord::from(vec![row.to_string()]);
        for row in 0..10_000_u64 {
            let distance = (row * 7919 % 10_000) as f64;
            best.offer(row, row == 5000, distance, &record(row));
        }
        let rows = best.into_rows();
        assert_eq!(rows.len(), BEST);
        assert!(rows.is_sorted_by_key(|(row, _)| *row));
        assert!(rows.iter().all(|(row, kept)| *kept == record(*row)));
        // The verified one, though it is far, and the 999 nearest.
        let far = |row: &u64| *row != 5000 && row * 7919 % 10_000 >= 999;
        assert!(rows.iter().any(|(row, _)| *row == 5000));
        assert!(!rows.iter().any(|(row, _)| far(row)));
    }
}
