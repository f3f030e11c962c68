//! Two independent samples, in blocks of base points whose scatter tells the error.

use sampling::{
    design::cube,
    random::{Purpose, Random},
};

/// Blocks of consecutive base points.
pub(crate) const BLOCKS: usize = 16;

/// Which block a base point belongs to.
pub(crate) fn block(row: usize, rows: usize) -> usize {
    row * BLOCKS / rows
}

/// Rows of two samples A and B in the unit cube: the first `parameters` numbers of a row are A's, the others B's.
///
/// Each block of rows is a scrambled net of its own, with its coordinates dealt out at random: in a net of a certain size some
/// two or three coordinates lie badly together, with errors of several times those of independent points, and nothing inside
/// of that net shows it. The errors of independent nets are independent, so that their scatter tells how large they are. One
/// net of all rows would come nearer for smooth outputs, but would not know how near.
///
/// # Errors
///
/// A net has too few coordinates or points.
pub fn pairs(parameters: usize, rows: u64, seed: u64) -> Result<Vec<Vec<f64>>, String> {
    let most = rows.div_ceil(BLOCKS as u64) * BLOCKS as u64;
    let nets = cube(2 * parameters, most, seed, BLOCKS as u64)?;
    let mut random = Random::new(seed, Purpose::Deal, 0);
    let orders: [Vec<usize>; BLOCKS] = std::array::from_fn(|_| {
        let mut order: Vec<usize> = (0..2 * parameters).collect();
        random.shuffle(&mut order);
        order
    });
    let mut used = [0; BLOCKS];
    let rows = rows as usize;
    let dealt = (0..rows).map(|row| {
        let net = block(row, rows);
        let point = &nets[used[net] * BLOCKS + net];
        used[net] += 1;
        orders[net].iter().map(|&k| point[k]).collect()
    });
    Ok(dealt.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the four points of each net every quarter of every coordinate holds one.
    #[test]
    fn every_block_is_a_net() {
        let rows = pairs(3, 64, 5).unwrap();
        for net in rows.chunks(4) {
            for k in 0..6 {
                let mut quarters: Vec<f64> = net.iter().map(|row| (4.0 * row[k]).floor()).collect();
                quarters.sort_by(f64::total_cmp);
                assert_eq!(quarters, [0.0, 1.0, 2.0, 3.0]);
            }
        }
        assert_eq!(pairs(3, 64, 5).unwrap(), rows);
        assert_ne!(pairs(3, 64, 6).unwrap(), rows);
    }

    #[test]
    fn any_number_of_rows_has_its_blocks() {
        for rows in [1, 5, 16, 17, 50, 257] {
            assert_eq!(pairs(2, rows, 1).unwrap().len() as u64, rows);
        }
    }
}
