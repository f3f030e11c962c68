//! A child of a keeper at work, on every system.
//!
//! The keeper asks nothing of its children: each is looked at now and then, so that one that is silent because it has
//! stopped, has ended with its pipe held open by others, or has swollen is noticed long before its deadline.

use std::{
    io,
    time::{Duration, Instant},
};

use super::{
    frame::{self, Inbox},
    keeper::{Answers, Keeper, Orders, Process},
    loss::{Bounds, Loss, Parting, State},
};

/// How long a child may take to end after it has closed its pipe.
const PATIENCE: Duration = Duration::from_secs(1);

/// A child at work.
#[derive(Debug)]
pub struct Child {
    process: Process,
    answers: Inbox<Answers>,
    orders: Orders,
    ticket: u64,
    /// Whether it has been waited for.
    gone: bool,
}

impl Child {
    pub(super) fn new(process: Process, answers: Answers, orders: Orders, ticket: u64) -> Self {
        Self { process, answers: Inbox::new(answers, ticket), orders, ticket, gone: false }
    }

    /// The memory that it occupies, bytes; 0 where that is not known.
    pub fn resident(&self) -> u64 {
        self.process.resident()
    }

    /// Sends it a message, which it must be waiting for: this blocks while it does not read.
    ///
    /// # Errors
    /// When it does not listen any more.
    pub fn send(&mut self, payload: &[u8]) -> io::Result<()> {
        frame::write(&mut self.orders, self.ticket, payload)
    }

    /// Waits for its next answer.
    ///
    /// # Errors
    /// When none comes; then the child is only good to be dropped.
    pub fn answer(&mut self, keeper: &mut Keeper, bounds: Bounds) -> Result<Vec<u8>, Loss> {
        let begun = Instant::now();
        loop {
            match self.answers.arrived() {
                Ok(Some(payload)) => return Ok(payload),
                Ok(None) => {}
                Err(broken) => return Err(Loss::Garbled(broken)),
            }
            if keeper.is_ready(&mut self.answers)? {
                match self.answers.read() {
                    Ok(true) => continue,
                    // Nobody can write any more; how the child ends says why.
                    Ok(false) => return Err(self.ending(keeper)),
                    Err(_) => return Err(Loss::Mute),
                }
            }
            match self.process.state() {
                State::Running => {}
                // It may have answered just before.
                _ if keeper.is_ready(&mut self.answers)? => continue,
                State::Stopped => return Err(Loss::Stopped),
                State::Ended(loss) => {
                    keeper.hear_the_last();
                    return Err(loss);
                }
            }
            if begun.elapsed() > bounds.time {
                return Err(Loss::Timeout);
            }
            if self.resident() > bounds.memory {
                return Err(Loss::Memory);
            }
        }
    }

    /// How a child ends whose pipe is closed. One that only closed it must not hold us up.
    fn ending(&mut self, keeper: &mut Keeper) -> Loss {
        let patience = Instant::now() + PATIENCE;
        while Instant::now() < patience {
            match self.process.state() {
                State::Ended(loss) => {
                    keeper.hear_the_last();
                    return loss;
                }
                State::Stopped => return Loss::Stopped,
                State::Running if keeper.is_orphaned() => return Loss::Orphaned,
                State::Running => {}
            }
            keeper.hear();
            self.process.await_end();
        }
        Loss::Mute
    }

    /// Lets a child that has answered end by itself, but not longer than `grace`; then ends it. It closes its pipe before
    /// it writes what the FMU has printed or put into files, so the closed pipe is not its end.
    pub fn part(mut self, keeper: &mut Keeper, grace: Duration) -> Parting {
        let until = Instant::now() + grace;
        let mut open = true;
        let mut loss = Some(Loss::Timeout);
        while Instant::now() < until {
            let arrived = if open {
                keeper.is_ready(&mut self.answers)
            } else if keeper.is_orphaned() {
                Err(Loss::Orphaned)
            } else {
                keeper.hear();
                self.process.await_end();
                Ok(false)
            };
            match arrived {
                Ok(true) => {
                    open = matches!(self.answers.read(), Ok(true));
                    continue;
                }
                Ok(false) => match self.process.state() {
                    State::Running => continue,
                    State::Stopped => loss = Some(Loss::Stopped),
                    State::Ended(_) => loss = None,
                },
                Err(_) => loss = None,
            }
            break;
        }
        // The last that it said may have come just before its end.
        while open && Instant::now() < until && keeper.is_ready(&mut self.answers) == Ok(true) {
            open = matches!(self.answers.read(), Ok(true));
        }
        let mut words = None;
        while let Ok(Some(payload)) = self.answers.arrived() {
            words = Some(payload);
        }
        let unusual = self.finish();
        keeper.hear_the_last();
        Parting { words, loss: loss.or(unusual) }
    }

    /// Ends the child, with all that it has started, at once; the loss that its status tells, where it did not end as a child does whose work is done.
    fn finish(&mut self) -> Option<Loss> {
        if std::mem::replace(&mut self.gone, true) {
            return None;
        }
        self.process.finish()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Keeper {
    /// The last line that children have printed since the last start of one, if any.
    pub fn last_line(&mut self) -> String {
        self.words.last_line()
    }

    /// All that is kept of what they have printed since then.
    pub fn text(&mut self) -> String {
        self.words.text()
    }
}
