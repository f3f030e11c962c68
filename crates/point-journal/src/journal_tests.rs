//! Tests of the journal: what was written comes back, damage costs its line.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::fs;

use super::*;
use crate::Error;
use fmu_points::{Conduct, failure::Failure};

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
        ..Header::default()
    }
}

fn written() -> (tempfile::TempDir, Vec<PointOutcome>) {
    let folder = tempfile::tempdir().unwrap();
    let outcomes =
        vec![Ok(vec![1.0 / 3.0, -2e-300]), Err(Failure::Error("it \"broke\"\nbadly".to_owned())), Ok(vec![0.1, 82.0])];
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    for (index, outcome) in [(3, 0), (0, 1), (1, 2)] {
        journal.append(index, &outcomes[outcome], None).unwrap();
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
        assert_eq!(reader.get(index).unwrap().as_ref(), Some(&outcomes[outcome]));
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
        let complete = whole[header_end..end].iter().filter(|&&byte| byte == b'\n').count();
        // A copy of the header stands before the three points, and another one behind them.
        let complete = complete.saturating_sub(1).min(3);
        assert_eq!(finished.count, complete as u64);
        journal.append(4, &Ok(vec![1.0]), None).unwrap();
        journal.flush().unwrap();
        let again = Finished::read(folder.path()).unwrap();
        assert_eq!(again.count, complete as u64 + 1);
    }
}

#[test]
fn a_changed_study_is_refused_with_what_differs() {
    let (folder, _) = written();
    let now = Header { seed: 2, ..header() };
    let error = Journal::resume(folder.path(), &now).unwrap_err();
    assert!(error.to_string().contains("another seed (1 then, 2 now)"), "{error}");
    let error = Journal::create(folder.path(), &header()).unwrap_err();
    assert!(matches!(error, Error::Begun(_)));
}

#[test]
fn what_is_joined_twice_counts_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    for index in 0..3 {
        journal.append(index, &Ok(vec![1.0]), None).unwrap();
    }
    let conduct = |same| Conduct { reproducible: Some(same), reproducibility: same.to_string(), ..Conduct::default() };
    for note in [conduct(true), conduct(false), conduct(true)] {
        journal.note(&Note::Conduct(note)).unwrap();
    }
    // Computed again, and joined with others.
    journal.append(2, &Ok(vec![2.0]), None).unwrap();
    journal.flush().unwrap();
    drop(journal);
    // What differed once stays known.
    assert_eq!(Finished::read(folder.path()).unwrap().conduct(), conduct(false));
    let other = tempfile::tempdir().unwrap();
    let mut joined = Journal::create(other.path(), &header()).unwrap();
    for _ in 0..2 {
        copy(folder.path(), &mut joined).unwrap();
    }
    let finished = Finished::read(other.path()).unwrap();
    assert_eq!((finished.count, finished.conduct()), (3, conduct(false)));
    assert_eq!(finished.outcomes().unwrap().get(2).unwrap(), Some(Ok(vec![2.0])));
}

/// The journal of version 0.2 had other lines.
#[test]
fn journals_of_another_form_are_answered_by_one_line() {
    let (folder, _) = written();
    let path = path_in(folder.path());
    let text = fs::read_to_string(&path).unwrap();
    let old: String = text
        .lines()
        .map(|line| {
            let line = line.split_once(' ').unwrap().1.replace("\"form\":3,", "");
            format!("{:08x} {line}\n", crc32fast::hash(line.as_bytes()))
        })
        .collect();
    fs::write(&path, old).unwrap();
    for error in [Finished::read(folder.path()).unwrap_err(), Journal::resume(folder.path(), &header()).unwrap_err()] {
        assert!(error.to_string().contains("was written by another version of this program"), "{error}");
    }
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
        (Ok(vec![f64::MIN_POSITIVE, 0.0]), Some(notices.clone())),
        (Ok(vec![2.0, 3.0]), None),
        (Err(Failure::Timeout), Some(notices.clone())),
        (Err(Failure::Error("it broke {".to_owned())), Some(notices)),
    ];
    for (index, (outcome, notices)) in (0..).zip(&points) {
        journal.append(index, outcome, notices.as_ref()).unwrap();
    }
    journal.flush().unwrap();
    let finished = Finished::read(folder.path()).unwrap();
    let mut outcomes = finished.outcomes().unwrap();
    for (index, expected) in (0..).zip(points) {
        assert_eq!(outcomes.get_noted(index).unwrap(), Some(expected));
    }
}

/// A line may have a right checksum and be none that the program wrote.
#[test]
fn points_of_one_journal_have_as_many_values() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(folder.path(), &header()).unwrap();
    for (index, values) in [vec![1.0, 2.0], vec![1.0, 2.0, 3.0]].into_iter().enumerate() {
        journal.append(index as u64, &Ok(values), None).unwrap();
    }
    journal.flush().unwrap();
    let finished = Finished::read(folder.path()).unwrap();
    let mut outcomes = finished.outcomes().unwrap();
    assert!(outcomes.get(0).is_ok());
    assert!(outcomes.get(1).unwrap_err().to_string().contains("the line of point 2 is damaged"));
}

/// A journal of 300 points with sets, as an analysis writes it, and the value of each point.
fn long() -> (tempfile::TempDir, Header) {
    let folder = tempfile::tempdir().unwrap();
    let header = Header { points: None, ..header() };
    let mut journal = Journal::create(folder.path(), &header).unwrap();
    for index in 0..300_u64 {
        if index % 100 == 0 {
            journal.append_set(index, "100 5d41402a").unwrap();
        }
        let outcome = match index % 7 {
            0 => Err(Failure::Error(format!("point {index} broke"))),
            _ => Ok(vec![index as f64, 1.0 / (index as f64 + 1.0)]),
        };
        journal.append(index, &outcome, None).unwrap();
        if index % 50 == 49 {
            journal.sync().unwrap();
        }
    }
    journal.append_end();
    journal.sync().unwrap();
    (folder, header)
}

/// Damages some bytes; returns how many lines that costs at most.
fn damage_somewhere(bytes: &mut Vec<u8>, random: &mut StdRng) -> u64 {
    let at = random.random_range(0..bytes.len());
    let mut ends: Vec<usize> = (0..bytes.len()).filter(|&k| bytes[k] == b'\n').collect();
    ends.insert(0, 0);
    let line = |k: usize| ends[k]..ends[k + 1];
    let some = random.random_range(1..ends.len() - 1);
    match random.random_range(0..6) {
        0 => {
            bytes[at] ^= 1 << random.random_range(0..8);
            2
        }
        1 => {
            let end = (at + random.random_range(1..40)).min(bytes.len());
            bytes.drain(at..end);
            4
        }
        2 => {
            let strange: Vec<u8> = (0..random.random_range(1..40)).map(|_| random.random()).collect();
            bytes.splice(at..at, strange);
            2
        }
        3 => {
            let twice = bytes[line(some)].to_vec();
            bytes.splice(ends[some]..ends[some], twice);
            0
        }
        4 => {
            let (first, second) = (line(some), line(some - 1));
            let swapped = [&bytes[first.clone()], &bytes[second.clone()]].concat();
            bytes.splice(second.start..first.end, swapped);
            // A set that comes after its first point makes that one open.
            1
        }
        _ => {
            let end = (at + 200).min(bytes.len());
            let lines = bytes[at..end].iter().filter(|&&byte| byte == b'\n').count();
            bytes[at..end].fill(0);
            lines as u64 + 1
        }
    }
}

#[test]
fn damage_anywhere_costs_its_lines_and_nothing_else() {
    let (folder, header) = long();
    let path = path_in(folder.path());
    let whole = fs::read(&path).unwrap();
    let right = Finished::read(folder.path()).unwrap();
    let right: Vec<_> = {
        let mut outcomes = right.outcomes().unwrap();
        (0..300).map(|index| outcomes.get(index).unwrap()).collect()
    };
    let mut random = StdRng::seed_from_u64(1);
    for round in 0..200 {
        let mut damaged = whole.clone();
        let cost = damage_somewhere(&mut damaged, &mut random);
        fs::write(&path, damaged).unwrap();
        let (mut journal, finished) = Journal::resume(folder.path(), &header).unwrap();
        assert!(finished.count + cost >= 300, "{round}: {} points", finished.count);
        let mut outcomes = finished.outcomes().unwrap();
        for index in 0..300 {
            match outcomes.get(index).unwrap() {
                Some(outcome) => assert_eq!(Some(outcome), right[index as usize], "{round}"),
                None => {
                    let again = right[index as usize].as_ref().unwrap();
                    journal.append(index, again, None).unwrap();
                }
            }
        }
        journal.sync().unwrap();
        let healed = Finished::read(folder.path()).unwrap();
        assert_eq!((healed.count, healed.damaged), (300, 0), "{round}");
        assert_eq!(healed.sets.len(), 3, "{round}");
    }
}
