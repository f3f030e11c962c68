use super::*;

/// While a worker probes, an audit of another one may find that new processes differ. The probe's end must not bring
/// forks back: their results do not count any more, so the run would never end.
#[test]
fn a_probe_that_ends_late_changes_nothing_that_is_known() {
    for give_up in [true, false] {
        let policy = Policy::new(Isolation::Audited, false);
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

/// A search asks for a few points, looks at them, and asks again.
#[test]
fn a_search_that_asks_for_few_points_at_a_time_earns_reuse() {
    const TAKES: f64 = 0.01;
    let policy = Policy::new(Isolation::Audited, false);
    for _ in 0..PROBES {
        assert_eq!(policy.plan(Some(10)), Plan::Probe);
        policy.probed(Probed::Alike, Duration::ZERO);
    }
    let job = Job {
        index: 0,
        values: vec![1.0],
    };
    let mut points = 0;
    while let Plan::Alone(separation) = policy.plan(Some(10)) {
        policy.note(&job, &[1.0], separation, Some(TAKES));
        points += 1;
        assert!(points < 1000);
    }
    assert_eq!(
        (policy.plan(Some(10)), points),
        (Plan::Alone(Separation::Forked), 481)
    );
}
