//! Tests of the command line, from outside. They are one program, since each program links the whole orchestrator, and
//! their tests, many of which wait for processes, run side by side.
#![allow(clippy::unwrap_used)]

mod analysis;
mod broken;
mod budget;
mod cases;
mod commands;
mod compared;
mod concerns;
mod curves;
mod damage;
mod durability;
mod exchange;
mod faults;
mod finale;
mod folders;
mod gate;
mod identified;
mod integrated;
mod interrupted;
mod isolation;
mod mistakes;
mod mutations;
mod optima;
mod packed;
mod rare;
mod regions;
mod reuse;
mod samples;
mod sensitivities;
mod simulate;
mod starting;
mod statistics;
mod strangers;
mod support;
mod three;
mod typed;
mod verdicts;
