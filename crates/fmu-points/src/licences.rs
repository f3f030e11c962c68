//! Waiting for licences: an instance that is refused for want of one is asked for again.

use std::time::{Duration, Instant};

/// How long a licence is waited for while no other point gets one, and where none ever did.
const LICENCE: Duration = Duration::from_secs(600);
const FIRST_LICENCE: Duration = Duration::from_secs(60);

/// The reaction to an instance that was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wait {
    /// It stays refused.
    No,
    /// Ask again.
    Again,
    /// Ask again, and tell the user for how long at most.
    Told(Duration),
    /// It stays refused, and so will others: tell the user.
    GivenUp(Duration),
}

/// What the workers of a run know of the FMU's licences.
#[derive(Debug, Default)]
pub struct Licences {
    /// Whether a tool stands behind the FMU.
    tool: bool,
    /// When an instance was made last.
    had: Option<Instant>,
    /// Whether the user was told that a licence is waited for, and whether that was in vain.
    told: bool,
    hopeless: bool,
}

impl Licences {
    /// Those of an FMU behind which a tool stands or not.
    pub fn new(tool: bool) -> Self {
        Self { tool, ..Self::default() }
    }

    /// Notes that an instance was made.
    pub fn note(&mut self) {
        self.had = Some(Instant::now());
        self.hopeless = false;
    }

    /// Whether a refused instance is to be asked for again: it spoke of a licence, or the tool behind the FMU gave one
    /// before. A point waits no longer than it may take, and where nobody got an instance for a whole round, no further one
    /// is waited for until somebody does.
    pub fn wait(&mut self, spoken: bool, since: Instant, limit: Duration) -> Wait {
        let wanted = spoken || self.tool && self.had.is_some();
        if !wanted || self.hopeless {
            return Wait::No;
        }
        let round = self.had.map_or(FIRST_LICENCE, |_| LICENCE).min(limit);
        let last = self.had.map_or(since, |last| last.max(since));
        if last.elapsed() >= round {
            self.hopeless = true;
            return Wait::GivenUp(round);
        }
        if since.elapsed() >= limit {
            return Wait::No;
        }
        if std::mem::replace(&mut self.told, true) { Wait::Again } else { Wait::Told(round) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_licence_is_waited_for_where_there_may_be_one() {
        let mut licences = Licences::new(true);
        let (now, limit) = (Instant::now(), Duration::from_secs(3600));
        assert_eq!(licences.wait(false, now, limit), Wait::No);
        assert_eq!(licences.wait(true, now, limit), Wait::Told(FIRST_LICENCE));
        assert_eq!(licences.wait(true, now, limit), Wait::Again);
        licences.note();
        assert_eq!(licences.wait(false, now, limit), Wait::Again);
        assert_eq!(licences.wait(true, now, Duration::ZERO), Wait::GivenUp(Duration::ZERO));
        // Nobody waits after that until somebody gets one.
        assert_eq!(licences.wait(true, now, limit), Wait::No);
        licences.note();
        assert_eq!(licences.wait(true, now, limit), Wait::Again);
    }
}
