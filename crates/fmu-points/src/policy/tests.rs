use super::*;

/// While a worker probes, an audit of another one may find that new processes differ. The probe's end must not bring
/// forks back: their results do not count any more, so the run would never end.
#[test]
fn a_probe_that_ends_late_changes_nothing_that_is_known() {
    for give_up in [true, false] {
        let mut policy = Policy::new(Isolation::Audited, false, false);
        assert_eq!(policy.plan(None), Plan::Probe);
        match give_up {
            true => policy.give_up_reproducing(),
            false => policy.refute(Separation::Forked),
        }
        for _ in 0..PROBES {
            policy.probed(Probed::Alike, Duration::from_secs(2));
        }
        assert_eq!(policy.alone(), Separation::New);
        assert_eq!(policy.plan(None), Plan::Alone(Separation::New));
    }
}

/// A point that was computed alone, and of which the simulation took so long, s.
fn alone(simulated: f32, odd: Option<Reason>) -> Reply {
    Reply { index: 0, answer: Ok(vec![1.0].into()), start: 0.0, simulated, odd, forkable: None }
}

const JOB: Job = Job { index: 0, values: Vec::new() };

fn probed(left: usize) -> Policy {
    let mut policy = Policy::new(Isolation::Audited, false, false);
    for _ in 0..PROBES {
        assert_eq!(policy.plan(Some(left)), Plan::Probe);
        policy.probed(Probed::Alike, Duration::ZERO);
    }
    policy
}

/// A search asks for a few points, looks at them, and asks again.
#[test]
fn a_search_that_asks_for_few_points_at_a_time_earns_reuse() {
    let mut policy = probed(10);
    let mut points = 0;
    while let Plan::Alone(separation) = policy.plan(Some(10)) {
        policy.note(&JOB, &alone(0.001, None), separation, Some(0.01));
        points += 1;
        assert!(points < 1000);
    }
    assert_eq!((policy.plan(Some(10)), points), (Plan::Alone(Separation::Forked), 481));
}

/// Neither a stall of the machine nor how fast it is decides, only which part of its time a point is simulated, mostly.
#[test]
fn no_single_reading_of_a_clock_decides() {
    for machine in [1e-4, 1.0, 1e3] {
        let mut policy = probed(1000);
        for number in 0..PROOF {
            let took = machine * if number % 3 == 0 { 500.0 } else { 1.0 };
            let reply = alone(0.1 * machine as f32, None);
            policy.note(&JOB, &reply, Separation::Forked, Some(took));
        }
        assert_eq!(policy.plan(Some(1000)), Plan::Trial);
    }
    // A refusal because points take long is none for good.
    let mut policy = probed(1000);
    for _ in 0..PROOF {
        policy.note(&JOB, &alone(0.95, None), Separation::Forked, Some(1.0));
    }
    assert_eq!(policy.plan(Some(1000)), Plan::Alone(Separation::Forked));
    assert_eq!(policy.conduct().isolation_reason, Some(Reason::LongPoints));
    for _ in 0..PROOF {
        policy.note(&JOB, &alone(0.5, None), Separation::Forked, Some(1.0));
    }
    assert_eq!(policy.plan(Some(1000)), Plan::Trial);
}

/// Where many points are odd, sharing saves nothing, until they are not any more.
#[test]
fn odd_points_run_alone_while_they_are_many() {
    let mut policy = probed(1000);
    let note = |policy: &mut Policy, odd| policy.note(&JOB, &alone(0.1, odd), Separation::Forked, Some(1.0));
    (0..PROOF).for_each(|_| note(&mut policy, None));
    assert_eq!(policy.plan(Some(1000)), Plan::Trial);
    policy.tried(Some(Ok(Reuse::Reset)));
    policy.reused = true;
    for place in 0..LATEST {
        policy.note_odd((place % 50 == 0).then_some(Reason::Complaints));
    }
    assert_eq!(policy.plan(Some(1000)), Plan::Used(Reuse::Reset));
    (0..=MANY).for_each(|_| policy.note_odd(Some(Reason::Threads)));
    assert_eq!(policy.plan(Some(1000)), Plan::Alone(Separation::Forked));
    assert_eq!(policy.conduct().isolation_reason, Some(Reason::Threads));
    (0..LATEST).for_each(|_| note(&mut policy, None));
    assert_eq!(policy.plan(Some(1000)), Plan::Used(Reuse::Reset));
    assert_eq!(policy.conduct().isolation_reason, None);
}

/// A text that names a licence must not cost a round of waiting for each point.
#[test]
fn a_licence_is_waited_for_once_in_vain() {
    let mut policy = Policy::new(Isolation::Audited, false, false);
    let limit = Duration::from_secs(3);
    let now = Instant::now();
    assert_eq!(policy.wait(false, now, limit), Wait::No);
    assert_eq!(policy.wait(true, now, limit), Wait::Told(limit));
    assert_eq!(policy.wait(true, now, limit), Wait::Again);
    assert_eq!(policy.wait(true, now, Duration::ZERO), Wait::GivenUp(Duration::ZERO));
    assert_eq!(policy.wait(true, Instant::now(), limit), Wait::No);
    // Somebody got one: the next one that is refused may get one, too.
    policy.instantiated(0.1);
    assert_eq!(policy.wait(true, Instant::now(), limit), Wait::Again);
}

/// Workers on several machines: one finds out what all heed, and each audit counts once.
#[test]
fn what_one_worker_finds_others_heed() {
    let policy = || Policy::new(Isolation::Audited, false, true);
    let (mut supervisor, mut finder, mut other) = (policy(), policy(), policy());
    let tell = |supervisor: &mut Policy, to: &mut Policy, led: bool| {
        let mut known = supervisor.known();
        known.led = led;
        to.adopt(&known);
    };
    tell(&mut supervisor, &mut other, true);
    assert_eq!(other.plan(None), Plan::Alone(Separation::New));
    tell(&mut supervisor, &mut finder, false);
    for _ in 0..PROBES {
        assert_eq!(finder.plan(None), Plan::Probe);
        finder.probed(Probed::Alike, Duration::ZERO);
    }
    finder.sharing = Sharing::Earned(Reuse::Reset);
    finder.audited(7, true, true);
    finder.spend(Separation::Used, 20.0);
    finder.note_audit(0.5, Separation::Used, true, false);
    // It spends time, too, and tells of it later.
    other.spend(Separation::Used, 10.0);
    for _ in 0..2 {
        // What was told is not told again.
        supervisor.adopt(&finder.found());
        tell(&mut supervisor, &mut finder, false);
    }
    tell(&mut supervisor, &mut other, true);
    assert_eq!(other.plan(None), Plan::Used(Reuse::Reset));
    assert_eq!(supervisor.conduct().audits, 1);
    supervisor.adopt(&other.found());
    for policy in [&mut finder, &mut other] {
        // The audits are a part of the time of all.
        tell(&mut supervisor, policy, true);
        let [used, alone] = policy.spent.kinds;
        // 2 % of 30 s but for the half second: each has the part that it has computed.
        let tenth = 0.1 * used.here / used.computed;
        assert!((used.allowance() - tenth).abs() < 1e-12 && [10.0, 20.0].contains(&used.here));
        assert_eq!((used.computed, used.audited, used.audits), (30.0, 0.5, 1.0));
        assert_eq!((alone.computed, policy.spent.in_any_case), (0.0, 0.5));
    }
    other.refute(Separation::Forked);
    supervisor.adopt(&other.found());
    tell(&mut supervisor, &mut finder, false);
    assert_eq!(finder.plan(None), Plan::Alone(Separation::New));
    assert_eq!(supervisor.conduct().audits, 1);
}

/// A worker tells what it found before it learnt that the FMU changes its folder. Points with a folder each would be computed in
/// the shared one again, where they count no more: the run would never end.
#[test]
fn what_was_found_in_a_shared_folder_says_nothing_of_folders_apart() {
    let shared = Mutex::new(Policy::new(Isolation::Audited, false, true));
    let apart = Mutex::new(Policy::apart(false, true));
    let mut late = Policy::new(Isolation::Audited, false, true);
    late.give_up_reproducing();
    let mut found = late.found();
    Policy::adopt_in([&shared, &apart], &found);
    assert_eq!(locked(&apart).alone(), Separation::Apart);
    assert!(!locked(&apart).differing && locked(&shared).differing);
    found.changed = Some("log.txt".to_owned());
    Policy::adopt_in([&shared, &apart], &found);
    assert!(locked(&apart).differing);
}
