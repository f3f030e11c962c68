//! The small commands around a study.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Bench, model};

#[test]
fn a_sound_fmu_has_no_findings() {
    let bench = Bench::new();
    let said = bench.run(&["check", "lag.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("nothing found"));
}

#[test]
fn a_doubtful_fmu_has_findings() {
    let bench = Bench::empty();
    let description = model("valueReference=\"30\"", "valueReference=\"x\"");
    bench.fmu("odd.fmu", &[], &description);
    let said = bench.run(&["check", "odd.fmu"]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.out.contains("lag.text"), "{}", said.out);
    let startless = model("declaredType=\"Fault\" start=\"0\"", "declaredType=\"Fault\"");
    bench.fmu("plain.fmu", &["NO_RESET"], &startless);
    let said = bench.run(&["check", "plain.fmu"]);
    assert_eq!(said.code, 1, "{}", said.out);
    for words in ["lag.fault: no start value", "does not export fmi2Reset"] {
        assert!(said.out.contains(words), "{}", said.out);
    }
}

#[test]
fn shells_get_their_completion() {
    let bench = Bench::empty();
    for shell in ["bash", "zsh", "fish"] {
        let said = bench.run(&["completion", shell]);
        assert!(said.code == 0 && said.out.contains("verify"), "{shell}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let bench = Bench::empty();
    let said = bench.run(&["manual", "share/man1"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(bench.read("share/man1/orchestrator.1").contains("verify"));
    assert!(bench.read("share/man1/orchestrator-verify.1").contains("shard"));
    // Commands that only the program itself gives are nobody's to read about.
    assert!(!bench.path("share/man1/orchestrator-worker.1").exists());
    bench.write("file", "");
    bench.run(&["manual", "file"]).is_mistake(&["file: "]);
}

#[test]
fn a_guid_that_the_binary_refuses_is_named() {
    let bench = Bench::empty();
    let other = "{0d9ba4ee-0000-4d1a-8d3c-2b1f0c6e5a77}";
    let description = model("guid=\"lag\"", &format!("guid=\"{other}\""));
    bench.fmu("other.fmu", &["SILENT"], &description);
    let cause = format!("the GUID of the description, {other}, does not occur in the binary");
    let said = bench.run(&["check", "other.fmu"]);
    assert_eq!(said.code, 1);
    assert!(said.out.contains(&cause), "{}", said.out);
    bench.run(&["simulate", "other.fmu"]).is_mistake(&["fmi2Instantiate", &cause]);
}

#[test]
fn a_check_survives_an_fmu_that_replaces_descriptors() {
    let bench = Bench::empty();
    bench.fmu("taking.fmu", &["TAKES_DESCRIPTORS"], &model("", ""));
    let said = bench.run(&["check", "taking.fmu"]);
    assert_eq!(said.code, 0, "{}", said.out);
    assert!(said.out.contains("nothing found"), "{}", said.out);
}

/// On a busy machine a probe may take longer than the first one did.
#[test]
fn a_check_that_is_late_once_is_no_finding() {
    let bench = Bench::empty();
    let check = |delay: &str| {
        bench.fmu("late.fmu", &[delay], &model("", ""));
        bench.run(&["check", "late.fmu", "--patience", "1.5"])
    };
    let said = check("SLOW_RESET=2000000");
    assert_eq!(said.code, 0, "{}", said.out);
    let said = check("SLOW_RESET=20000000");
    assert_eq!(said.code, 1, "{}", said.out);
    let words = "fmi2Reset failed: not done after 4.5 s, where a first simulation was done within 1.5 s";
    assert!(said.out.contains(words), "{}", said.out);
}

#[test]
fn a_signal_leaves_no_unpacked_fmu_behind() {
    let bench = Bench::empty();
    bench.fmu("hanging.fmu", &["FAULT=HANG"], &model("", ""));
    fs::create_dir(bench.path("scratch")).unwrap();
    let unpacked = || fs::read_dir(bench.path("scratch")).unwrap().count();
    for command in ["simulate", "check"] {
        for signal in ["-INT", "-TERM", "-HUP"] {
            // Where `nohup` runs the tests, hangups are ignored, and the command would heed that.
            let mut run = Command::new("env")
                .args(["--default-signal=HUP", env!("CARGO_BIN_EXE_orchestrator")])
                .args([command, "hanging.fmu"])
                .current_dir(bench.path("."))
                .env("TMPDIR", bench.path("scratch"))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            while unpacked() == 0 {
                assert!(run.try_wait().unwrap().is_none());
                sleep(Duration::from_millis(2));
            }
            // Somewhere while it is unpacked, loaded or simulated.
            sleep(Duration::from_millis(100));
            let kill = Command::new("kill").args([signal, &run.id().to_string()]).status();
            assert!(kill.unwrap().success());
            assert_eq!(run.wait().unwrap().code(), Some(130), "{command} {signal}");
            let rest = Command::new("find").arg(bench.path("scratch")).output().unwrap();
            assert_eq!(unpacked(), 0, "{command} {signal}: {}", String::from_utf8_lossy(&rest.stdout));
        }
    }
}
