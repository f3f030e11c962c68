//! The search for a film's periodic orbit: the state that a turn of the load leads back to.
//!
//! Thick oil takes tens of turns until its content and the journal's whirl repeat themselves. Few directions of the state are
//! so slow. Anderson's mixing (1965, J. ACM 12, 547-560; in the form of Walker & Ni 2011, SIAM J. Numer. Anal. 49, 1715-1735)
//! learns these from the turns themselves: the next start is the combination of the last ends whose misses cancel best.

use nalgebra::{DMatrix, DVector, Vector2};

use super::state::State;

/// Turns that are combined at the most.
const DEPTH: usize = 6;
/// A turn that misses its beginning by more than the last one times this tells that the past is no guide.
const ASTRAY: f64 = 1.5;
/// Directions of the misses that are weaker than this share of the strongest one are rounding.
const WEAKEST: f64 = 1e-6;
/// A cell that lacks no more than this share of its gap is full.
const FULL: f64 = 1e-9;
/// The combination leaves at least this share of the gap that the last turn left.
const LEAST_GAP: f64 = 0.5;
/// The gap that counts where it is smaller, or the mean planes of rough surfaces have crossed.
const LEAST_ROOM: f64 = 1e-3;

/// A film's search for its periodic orbit, see [`ReynoldsFilm::end_turn`](super::film::ReynoldsFilm::end_turn).
#[derive(Clone, Debug)]
pub struct PeriodicSearch {
    /// Where the present turn began.
    start: State,
    /// The last turns, the latest one last.
    turns: Vec<MissedTurn>,
}

/// By how much a turn missed its beginning, and where it ended.
#[derive(Clone, Debug)]
struct MissedTurn {
    miss: DVector<f64>,
    end: DVector<f64>,
}

impl PeriodicSearch {
    pub(super) fn new(start: &State) -> Self {
        Self { start: start.clone(), turns: Vec::new() }
    }

    /// Takes over the end of a turn. Returns where the next one should begin, and how far that is from where this one began:
    /// change of eccentricity ratio and content, root of the sum of both mean squares.
    pub(super) fn next(&mut self, end: &State) -> (&State, f64) {
        let (from, to) = (unknowns(&self.start), unknowns(end));
        let miss = &to - &from;
        let size = miss.norm();
        let astray = |last: &MissedTurn| size > ASTRAY * last.miss.norm();
        if self.turns.last().is_some_and(astray) {
            self.turns.clear();
        }
        if self.turns.len() == DEPTH {
            self.turns.remove(0);
        }
        self.turns.push(MissedTurn { miss, end: to });
        self.start.copy_from(end);
        if let Some(mixed) = self.mixed() {
            take_over(&mixed, end, &mut self.start);
        }
        let moved = (unknowns(&self.start) - from).norm();
        (&self.start, moved)
    }

    /// The combination of the ends whose misses cancel best; `None` for a single turn.
    fn mixed(&self) -> Option<DVector<f64>> {
        let (last, before) = self.turns.split_last()?;
        if before.is_empty() {
            return None;
        }
        let differences = |of: fn(&MissedTurn) -> &DVector<f64>| {
            let steps: Vec<_> = (self.turns.windows(2)).map(|pair| of(&pair[1]) - of(&pair[0])).collect();
            DMatrix::from_columns(&steps)
        };
        let of_misses = differences(|turn| &turn.miss);
        let svd = of_misses.svd(true, true);
        let weakest = WEAKEST * svd.singular_values.max();
        let weights = svd.solve(&last.miss, weakest).ok()?;
        let mixed = &last.end - differences(|turn| &turn.end) * weights;
        mixed.iter().all(|x| x.is_finite()).then_some(mixed)
    }
}

/// What of a state a turn must lead back to: the eccentricity ratio, and the content of each cell with the weight of one cell
/// among all.
fn unknowns(state: &State) -> DVector<f64> {
    let weight = weight(state);
    let content = state.field.content.iter().map(|content| content * weight);
    let eps = [state.eps.x, state.eps.y];
    DVector::from_iterator(2 + state.field.content.len(), eps.into_iter().chain(content))
}

fn weight(state: &State) -> f64 {
    (state.field.content.len() as f64).sqrt().recip()
}

/// Puts unknowns into a state whose end of the turn was `end`, unless they would close the gap.
fn take_over(unknowns: &DVector<f64>, end: &State, state: &mut State) {
    let eps = Vector2::new(unknowns[0], unknowns[1]);
    let room = (1.0 - end.eps.norm()).max(LEAST_ROOM);
    if eps.norm() - end.eps.norm() > (1.0 - LEAST_GAP) * room {
        return;
    }
    state.eps = eps;
    let weight = weight(end);
    let field = &mut state.field;
    for cell in 0..field.content.len() {
        let content = (unknowns[2 + cell] / weight).clamp(0.0, 1.0);
        if (content - field.content[cell]).abs() <= FULL {
            continue;
        }
        let full = content >= 1.0 - FULL;
        // A cell with pressure keeps it as the next solution's first guess.
        field.content[cell] = if full { 1.0 } else { content };
        if field.full[cell] != full {
            field.pressure[cell] = 0.0;
        }
        field.full[cell] = full;
    }
}
