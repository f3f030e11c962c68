//! The comparisons that tell how far the FMU's points may share processes: probes of the first points, trials of used
//! processes, and audits of results.

use std::time::Instant;

use super::{Done, FILLS, Isolated, bits, is_same, speaks_of_the_fmu, tell};
use crate::conduct::{Reason, Separation};
use crate::points::{Event, Job, Post};
use crate::policy::Probed;
use crate::process::Gone;
use crate::runner::Reuse;
use crate::wire::{Order, Outcome, Reply};

impl Isolated {
    /// Runs a point in several ways, and reports it.
    pub(super) fn probe(&mut self, job: &Job, post: &mut Post<'_>) -> Result<(), Gone> {
        let begun = Instant::now();
        let outcome = self.compare(job, post);
        let nothing = Probed::Nothing;
        let probed = outcome.as_ref().map_or(nothing, |(probed, _)| *probed);
        self.policy().probed(probed, begun.elapsed());
        let (probed, answer) = outcome?;
        let new = self.strictest();
        let answer = match answer {
            // Memory was filled to find differences, and new processes differ. The result that counts is the one
            // without filling.
            _ if probed == Probed::Different => {
                self.give_up_reproducing(post);
                self.alone(job, new, post)?.0
            }
            Some(reply) => {
                let each = begun.elapsed().as_secs_f64() / 2.0;
                self.policy().note(job, &reply, new, Some(each));
                reply.answer
            }
            None => self.alone(job, new, post)?.0,
        };
        if answer.is_err() {
            self.policy().note_odd(Some(Reason::Complaints));
        }
        tell(post, job.index, answer, new);
        Ok(())
    }

    /// A point under two patterns of unwritten memory, and in a fork.
    fn compare(&mut self, job: &Job, post: &mut Post<'_>) -> Result<(Probed, Option<Reply>), Gone> {
        let [first, second] = FILLS.map(Some);
        let first = self.anew(job, first, post)?;
        if let Some(reason) = self.unloadable(&first.answer) {
            return Err(Gone::Unloadable(reason));
        }
        let second = self.anew(job, second, post)?;
        let same = is_same(&first.answer, &second.answer);
        // A process that was ended from outside tells nothing about the FMU.
        let mut told = speaks_of_the_fmu(&first.answer) && speaks_of_the_fmu(&second.answer);
        if told && self.is_crowd(&first.answer, &second.answer) {
            post.send(Event::Fickle(job.index));
            told = false;
        }
        if told && (first.answer.is_ok() || second.answer.is_ok()) {
            self.policy().audited(job.index, same, false);
        }
        if !same {
            let probed = if told { Probed::Different } else { Probed::NoForks };
            return Ok((probed, None));
        }
        let mut probed = Probed::NoForks;
        let shared = self.strictest() == Separation::New;
        if first.forkable == Some(true) && shared && !self.policy().is_dear() {
            let forked = self.licensed(job, Separation::Forked, None, post)?;
            if is_same(&first.answer, &forked.answer) {
                probed = Probed::Alike;
            }
        }
        Ok((probed, Some(first)))
    }

    /// Finds out whether processes may be used again, and how: points that are known, in both orders and repeated.
    pub(super) fn trial(&mut self, post: &Post<'_>) -> Result<Result<Reuse, Reason>, Gone> {
        let proof = self.policy().proof();
        let forward = 0..proof.len();
        let orders: Vec<usize> =
            forward.clone().chain(forward.clone().rev()).chain(forward.flat_map(|k| [k, k])).collect();
        let jobs: Vec<Job> =
            orders.iter().zip(0..).map(|(&k, index)| Job { index, values: proof[k].0.values.clone() }).collect();
        let mut outcome = Err(Reason::OtherResults);
        for reuse in [Reuse::Reset, Reuse::Renew] {
            let (mut same, mut odd) = (true, None);
            let way = |jobs| Order::Used(reuse, jobs);
            let ran = self.using.run(way, &jobs, post.stopped, &mut |reply| {
                let known = orders.get(reply.index as usize).map(|&k| &proof[k].1);
                let simulated = reply.answer.as_ref().ok();
                same &= known.zip(simulated).is_some_and(|(a, b)| bits(a).eq(bits(&b.values)));
                odd = odd.or(reply.odd);
            });
            match (ran, odd) {
                // The points ended plainly alone.
                (Ok(()), Some(odd)) if same => outcome = Err(odd),
                (Ok(()), None) if same => {
                    outcome = Ok(reuse);
                    break;
                }
                (Ok(()) | Err(Gone::Lost(_)), _) => {}
                (Err(gone), _) => return Err(gone),
            }
            self.using.end();
        }
        Ok(outcome)
    }

    /// Computes some of the points of a used process again: those that are chosen, those right behind an odd one, and others
    /// as far as there is time.
    pub(super) fn audit_some(&mut self, done: &[Done<'_>], post: &mut Post<'_>) -> Result<(), Gone> {
        if !self.policy().audits() || done.is_empty() {
            return Ok(());
        }
        let mut others = Vec::new();
        for point in done {
            let chosen = self.policy().chooses(point.job.index, point.behind_odd);
            if !chosen {
                others.push(point);
            } else if !self.audit(point, true, post)? {
                return Ok(());
            }
        }
        let last = post.left == Some(0);
        let count = self.policy().audits_of_used(last);
        if count == 0 {
            return Ok(());
        }
        // An effect that accumulates shows best in the very last point.
        let latest = done.last().filter(|_| last).map(|done| done.job.index);
        let rank = |point: &&Done<'_>| {
            let latest = latest == Some(point.job.index);
            (!latest, !point.behind_odd, self.policy().rank(point.job.index))
        };
        others.sort_by_cached_key(rank);
        for point in others.into_iter().take(count as usize) {
            if !self.audit(point, false, post)? {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Computes a point again in a new process whose unwritten memory holds something else. Whether it came out the
    /// same, as far as that can be told.
    pub(super) fn audit(&mut self, point: &Done<'_>, in_any_case: bool, post: &mut Post<'_>) -> Result<bool, Gone> {
        let (job, separation) = (point.job, point.separation);
        let begun = Instant::now();
        let again = self.anew(job, Some(FILLS[0]), post)?.answer;
        let behind_odd = in_any_case && point.behind_odd;
        let took = begun.elapsed().as_secs_f64();
        self.policy().note_audit(took, separation, in_any_case, behind_odd);
        // A process that was ended from outside tells nothing about the FMU.
        if !speaks_of_the_fmu(&again) {
            return Ok(true);
        }
        let first = Ok(point.values.clone().into());
        if separation == self.strictest() && self.is_crowd(&first, &again) {
            post.send(Event::Fickle(job.index));
            return Ok(true);
        }
        let agreed = is_same(&first, &again);
        // Behind an odd point it was the first in its process, where no other can have spoilt it.
        let shared = separation == Separation::Used && !point.behind_odd;
        self.policy().audited(job.index, agreed, shared);
        if !agreed {
            self.judge(job, separation, &again, post)?;
        }
        Ok(agreed)
    }

    /// A point in a new process whose unwritten memory holds something else, with its answer.
    pub(super) fn run_as_audit(&mut self, job: &Job, post: &mut Post<'_>) -> Result<(), Gone> {
        let mut outcome = self.anew(job, Some(FILLS[0]), post)?.answer;
        if outcome.is_err() {
            outcome = self.anew(job, Some(FILLS[0]), post)?.answer;
        }
        tell(post, job.index, outcome, self.strictest());
        Ok(())
    }

    /// A point gave something else in a new process: either it matters what ran before it, or new processes differ.
    fn judge(&mut self, job: &Job, separation: Separation, new: &Outcome, post: &mut Post<'_>) -> Result<(), Gone> {
        if separation == self.strictest() {
            self.give_up_reproducing(post);
            return Ok(());
        }
        self.refute(separation, post);
        for fill in [Some(FILLS[1]), None] {
            let again = self.anew(job, fill, post)?.answer;
            let told = speaks_of_the_fmu(&again) && !self.is_crowd(new, &again);
            if told && !is_same(new, &again) {
                self.give_up_reproducing(post);
                return Ok(());
            }
        }
        Ok(())
    }
}
