//! The stand without FMI. One program, because linking each file on its own takes longer than most of its tests.

#![allow(clippy::unwrap_used)]

mod bush;
mod description;
mod energy;
mod exchange;
mod extremes;
mod feed;
mod film_leaps;
mod fluctuation;
mod hot;
mod literature;
mod lives;
mod means;
mod mixed;
mod operation;
mod plane;
mod resting;
mod steady;
mod stribeck;
mod units;
mod validity;
mod warm;
mod whole;
