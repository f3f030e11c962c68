//! Where further runs tell most about the outputs.

use crate::surrogate::Surrogate;
use nalgebra::DMatrix;

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 8;

/// So many candidates, by their numbers: in turn the one at which the outputs of all surrogates together are least known, as far
/// as those chosen before it do not tell it. Each surrogate has its own points of the same candidates. Outputs count by their size.
pub fn most_open(surrogates: &[(&Surrogate, Vec<Vec<f64>>)], count: usize) -> Vec<usize> {
    let possible = |(surrogate, points): &(&Surrogate, Vec<Vec<f64>>)| -> Vec<DMatrix<f64>> {
        let standard = surrogate.standard(points);
        let of = |output: usize| {
            let mut values = surrogate.functions(output, EACH).at(&standard);
            centre(&mut values);
            values
        };
        (0..surrogate.checks().len()).map(of).collect()
    };
    let mut outputs: Vec<DMatrix<f64>> = surrogates.iter().flat_map(possible).collect();
    let candidates = surrogates.first().map_or(0, |(_, points)| points.len());
    let take = |outputs: &mut Vec<DMatrix<f64>>, best| outputs.iter_mut().for_each(|values| close(values, best));
    in_turn(&mut outputs, [candidates, count], take, |outputs, i| {
        Some(outputs.iter().map(|values| values.row(i).norm_squared()).sum())
    })
}

/// So many of the candidates, in turn the one that is worth most as long as any is worth something; `take` follows each choice.
pub fn in_turn<State>(
    state: &mut State,
    [candidates, count]: [usize; 2],
    take: impl Fn(&mut State, usize),
    worth: impl Fn(&State, usize) -> Option<f64>,
) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count {
        let free = (0..candidates).filter(|i| !chosen.contains(i));
        let worths = free.filter_map(|i| Some((i, worth(state, i)?)));
        let Some((best, _)) = worths.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        chosen.push(best);
        take(state, best);
    }
    chosen
}

/// Takes each row's mean away.
pub fn centre(values: &mut DMatrix<f64>) {
    for mut row in values.row_iter_mut() {
        let mean = row.mean();
        row.add_scalar_mut(-mean);
    }
}

/// What the value at one row tells of all others is no longer open.
pub fn close(values: &mut DMatrix<f64>, row: usize) {
    let row = values.row(row).into_owned();
    let of_row = row.norm_squared();
    if of_row > 0.0 {
        let told = &*values * row.transpose() / of_row;
        *values -= told * row;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surrogate::Run;

    /// Where there are no runs the output is open, and one new run there tells of its neighbour.
    #[test]
    fn runs_go_where_there_are_none_and_not_side_by_side() {
        let like: Vec<Vec<f64>> = (0..41).map(|k| vec![f64::from(k) / 40.0]).collect();
        let run = |x: f64| Run { point: vec![x], values: Some(vec![(6.0 * x).sin()]) };
        let runs: Vec<Run> = (0..14).map(|k| run(f64::from(k) / 40.0)).chain([run(1.0)]).collect();
        let surrogate = Surrogate::fit(&runs, &like, None, 1).unwrap();
        let candidates: Vec<Vec<f64>> = [0.1, 0.2, 0.6, 0.61, 0.8].map(|x| vec![x]).to_vec();
        let chosen = most_open(&[(&surrogate, candidates)], 2);
        assert!(chosen.iter().all(|i| *i >= 2), "{chosen:?}");
        assert!(!(chosen.contains(&2) && chosen.contains(&3)), "{chosen:?}");
    }
}
