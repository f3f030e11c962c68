//! Tests of the journal: what was written comes back, damage is cut off.

use super::*;
use crate::engine::{Conduct, Isolation, Separation};
use crate::failure::Failure;

fn header() -> Header {
    Header {
        orchestrator: "1".to_owned(),
        study: "s".to_owned(),
        fmu: "f".to_owned(),
        table: None,
        seed: 1,
        points: Some(5),
        shard: None,
        analysis: None,
    }
}

fn written() -> (tempfile::TempDir, Vec<Outcome>) {
    let folder = tempfile::tempdir().unwrap();
    let outcomes = vec![
        Ok(vec![1.0 / 3.0, -2e-300]),
        Err(Failure::Error("it \"broke\"\nbadly".to_owned())),
        Ok(vec![0.1, 82.0]),
    ];
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    for (index, outcome) in [(3, 0), (0, 1), (1, 2)] {
        journal
            .append(index, &outcomes[outcome], Separation::New, None)
            .unwrap();
    }
    journal.sync().unwrap();
    (folder, outcomes)
}

#[test]
fn what_was_written_comes_back_exactly() {
    let (folder, outcomes) = written();
    let finished = Finished::read(folder.path()).unwrap();
    assert_eq!(finished.count, 3);
    let mut reader = finished.outcomes().unwrap();
    for (index, outcome) in [(0, 1), (1, 2), (3, 0)] {
        assert_eq!(
            reader.get(index).unwrap().as_ref(),
            Some(&outcomes[outcome])
        );
    }
    assert_eq!(reader.get(2).unwrap(), None);
}

#[test]
fn a_damaged_end_is_cut_off_wherever_it_begins() {
    let (folder, _) = written();
    let path = path_in(folder.path());
    let whole = fs::read(&path).unwrap();
    let header_end = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    for end in header_end..=whole.len() {
        fs::write(&path, &whole[..end]).unwrap();
        let (mut journal, finished) = Journal::resume(folder.path(), &header()).unwrap();
        let complete = whole[header_end..end]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        assert_eq!(finished.count, complete as u64);
        journal
            .append(4, &Ok(vec![1.0]), Separation::New, None)
            .unwrap();
        journal.flush().unwrap();
        let again = Finished::read(folder.path()).unwrap();
        assert_eq!(again.count, complete as u64 + 1);
    }
}

#[test]
fn a_changed_study_is_refused_with_what_differs() {
    let (folder, _) = written();
    let now = Header {
        seed: 2,
        ..header()
    };
    let error = Journal::resume(folder.path(), &now).unwrap_err();
    assert!(
        error.to_string().contains("another seed (1 then, 2 now)"),
        "{error}"
    );
    let error = Journal::create(folder.path(), &header()).unwrap_err();
    assert!(matches!(error, ResultsError::Begun(_)));
}

#[test]
fn what_does_not_count_is_open_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    let ways = [Separation::New, Separation::Forked, Separation::Used];
    for (index, way) in (0..).zip(ways) {
        journal.append(index, &Ok(vec![1.0]), way, None).unwrap();
    }
    let audited = Conduct {
        isolation: Isolation::Audited,
        audits: 7,
        audits_of_shared: 5,
        audit_mismatches: 0,
        reproducible: Some(true),
        ..Conduct::NONE
    };
    journal.note(&Note::Conduct(audited.clone())).unwrap();
    journal.flush().unwrap();
    let finished = Finished::read(folder.path()).unwrap();
    assert_eq!(finished.conduct(), audited);
    assert_eq!(finished.of(Separation::Forked), [1, 2]);
    let wrong = Conduct {
        audits: 1,
        audit_mismatches: 1,
        ..audited.clone()
    };
    journal.note(&Note::Void(Separation::Used)).unwrap();
    journal.note(&Note::Conduct(wrong)).unwrap();
    journal.flush().unwrap();
    let finished = Finished::read(folder.path()).unwrap();
    assert_eq!(
        [0, 1, 2].map(|index| finished.has(index)),
        [true, true, false]
    );
    assert_eq!(finished.count, 2);
    let conduct = finished.conduct();
    assert_eq!(conduct.isolation, Isolation::Fresh);
    assert_eq!((conduct.audits, conduct.audit_mismatches), (8, 1));
    // Computed again, and joined with others.
    journal
        .append(2, &Ok(vec![2.0]), Separation::Forked, None)
        .unwrap();
    journal.flush().unwrap();
    drop(journal);
    let other = tempfile::tempdir().unwrap();
    let mut joined = Journal::create(other.path(), &header()).unwrap();
    copy(folder.path(), &mut joined).unwrap();
    let finished = Finished::read(other.path()).unwrap();
    assert_eq!((finished.count, finished.conduct()), (3, conduct));
    let value = finished.outcomes().unwrap().get(2).unwrap();
    assert_eq!(value, Some(Ok(vec![2.0])));
}

#[test]
fn what_the_fmu_said_comes_back_with_the_point() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    let notices = Notices {
        warnings: 20,
        first_warning: Some("{\"odd\" text} 1 2\n".to_owned()),
        ended: Some(0.5),
        ..Notices::default()
    };
    let points = [
        (Ok(vec![1.0, -0.5]), Some(notices.clone())),
        (Ok(vec![]), Some(notices.clone())),
        (Ok(vec![2.0, 3.0]), None),
        (Err(Failure::Timeout), Some(notices.clone())),
        (Err(Failure::Error("it broke {".to_owned())), Some(notices)),
    ];
    for (index, (outcome, notices)) in (0..).zip(&points) {
        journal
            .append(index, outcome, Separation::Used, notices.as_ref())
            .unwrap();
    }
    journal.flush().unwrap();
    let finished = Finished::read(folder.path()).unwrap();
    let mut outcomes = finished.outcomes().unwrap();
    for (index, expected) in (0..).zip(points) {
        assert_eq!(outcomes.get_noted(index).unwrap(), Some(expected));
    }
}

#[test]
fn a_lock_that_is_released_soon_is_waited_for() {
    let (folder, _) = written();
    let other = File::open(path_in(folder.path())).unwrap();
    other.lock().unwrap();
    let busy = Journal::resume(folder.path(), &header());
    assert!(matches!(busy, Err(ResultsError::Busy(_))));
    let released = std::thread::spawn(move || {
        sleep(Duration::from_millis(100));
        drop(other);
    });
    assert!(Journal::resume(folder.path(), &header()).is_ok());
    released.join().unwrap();
}
