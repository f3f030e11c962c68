//! The film about which the balances are linearised.

use super::balance::Balance;
use super::cells::Cells;
use super::gap::Gap;
use super::liquid::Liquid;
use super::stage::Stage;
use super::state::Field;

/// Gap, oil, field and balances at one place of the journal, in one stage.
#[derive(Clone, Copy)]
pub struct Base<'a> {
    pub cells: &'a Cells,
    pub gap: &'a Gap,
    pub liquid: &'a Liquid,
    pub field: &'a Field,
    pub balance: &'a Balance,
    pub stage: &'a Stage<'a>,
}
