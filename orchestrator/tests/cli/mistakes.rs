//! Every mistake of a user is answered by one clear line and exit code 2.

use std::process::Stdio;

use crate::support::{Bench, model};

const STUDY: &str = r#"
fmu = "lag.fmu"

[simulation]
stop = 2

[design]
points = 8

[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1

[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.02
"#;

/// Verifies the study with a part replaced.
fn verify(from: &str, to: &str) -> crate::support::Said {
    let bench = Bench::new();
    assert!(STUDY.contains(from));
    bench.write("study.toml", &STUDY.replace(from, to));
    bench.run(&["verify", "study.toml", "--verbose"])
}

#[test]
fn the_study_itself_is_right() {
    let said = verify("", "");
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn no_such_file() {
    let bench = Bench::empty();
    bench.run(&["inspect", "none.fmu"]).is_mistake(&["none.fmu: no such file"]);
    bench.run(&["verify", "none.toml"]).is_mistake(&["none.toml: no such file"]);
    verify("lag.fmu", "lost.fmu")
        .is_mistake(&["study.toml:2:7: lost.fmu: no such file in ", "did you mean `lag.fmu`?"]);
    verify("lag.fmu", "models/lag.fmu").is_mistake(&["study.toml:2:7: ", "there is no folder "]);
    let bench = Bench::new();
    bench.run(&["inspect", "lga.fmu"]).is_mistake(&["lga.fmu: no such file in ", "did you mean `lag.fmu`?"]);
}

#[test]
fn one_file_in_the_place_of_another() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    bench.write("table.csv", "Y\n0.8\n");
    bench.run(&["verify", "lag.fmu"]).is_mistake(&["lag.fmu: is an FMU", "`orchestrator init lag.fmu` writes one"]);
    bench
        .run(&["judge", "table.csv", "study.toml"])
        .is_mistake(&["table.csv: is a table, where a study (a TOML file) is needed"]);
    bench.run(&["judge", "study.toml", "lag.fmu"]).is_mistake(&["lag.fmu: a zip archive", "save the table as csv"]);
    bench.run(&["simulate", "study.toml"]).is_mistake(&["study.toml: a study, where an FMU is needed"]);
    bench.zip("two.ssp", &[("SystemStructure.ssd", b"<x/>")]);
    for command in ["simulate", "verify", "init"] {
        bench.run(&[command, "two.ssp"]).is_mistake(&["two.ssp", "a system of FMUs", "-m fmu_orchestrator system"]);
    }
    bench.run(&["simulate", "lag.fmu", "--set-from", "study.toml"]).is_mistake(&["study.toml: no SSP parameter set"]);
    for folder in ["study.toml", "study.toml/below"] {
        bench
            .run(&["verify", "study.toml", "--output", folder])
            .is_mistake(&["study.toml is a file, where a folder is needed"]);
    }
    bench.run(&["report", "study.toml"]).is_mistake(&["study.toml is a file, where a folder is needed"]);
    if cfg!(target_os = "linux") {
        bench
            .run(&["verify", "study.toml", "--output", "/proc/x"])
            .is_mistake(&["/proc/x: no folder can be made here; choose another --output"]);
        bench
            .run(&["verify", "study.toml", "--output", "/dev/null"])
            .is_mistake(&["/dev/null is a device or a pipe, where a folder is needed"]);
    }
    std::fs::write(bench.path("latin.toml"), b"# K\xfchlung").unwrap();
    bench
        .run(&["verify", "latin.toml"])
        .is_mistake(&["latin.toml: line 1 is not text in UTF-8; save the file as UTF-8"]);
}

#[test]
fn not_a_zip() {
    let bench = Bench::empty();
    bench.write("text.fmu", "This is not a zip.");
    bench.run(&["inspect", "text.fmu"]).is_mistake(&["text.fmu", "not a zip"]);
    bench.zip("other.fmu", &[("readme.txt", b"hello")]);
    bench.run(&["simulate", "other.fmu"]).is_mistake(&["other.fmu", "no modelDescription.xml"]);
}

#[test]
fn another_version() {
    let bench = Bench::empty();
    bench.fmu("four.fmu", &[], &model("fmiVersion=\"2.0\"", "fmiVersion=\"4.0\""));
    bench.run(&["inspect", "four.fmu"]).is_mistake(&["four.fmu", "FMI 4.0", "FMI 2.0 or 3.0 is needed"]);
}

#[test]
fn no_interface_and_no_functions_of_it() {
    let bench = Bench::empty();
    bench.fmu("none.fmu", &[], &model("<CoSimulation", "<Nothing"));
    bench.run(&["simulate", "none.fmu"]).is_mistake(&["none.fmu", "no Co-Simulation or Model Exchange"]);
    bench.fmu("me.fmu", &[], &model("<CoSimulation", "<ModelExchange"));
    bench.run(&["simulate", "me.fmu"]).is_mistake(&["me.fmu", "does not export `fmi2EnterEventMode`"]);
}

#[test]
fn no_binary_for_this_platform() {
    let bench = Bench::empty();
    let description = model("", "");
    let entries: [(&str, &[u8]); 2] =
        [("modelDescription.xml", description.as_bytes()), ("binaries/win64/lag.dll", b"")];
    bench.zip("windows.fmu", &entries);
    bench.run(&["simulate", "windows.fmu"]).is_mistake(&["windows.fmu", "platform", "win64"]);
    // `inspect` needs no binary for this machine.
    assert_eq!(bench.run(&["inspect", "windows.fmu"]).code, 0);
}

#[test]
fn a_damaged_binary() {
    let bench = Bench::empty();
    let description = model("", "");
    let entries: [(&str, &[u8]); 2] =
        [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", b"junk")];
    bench.zip("junk.fmu", &entries);
    bench.run(&["simulate", "junk.fmu"]).is_mistake(&["failed: junk.fmu: cannot load binaries/linux64/lag.so: file"]);
}

#[test]
fn unknown_variables_get_a_suggestion() {
    verify("lag.rate", "lag.rato").is_mistake(&["study.toml:10:13", "did you mean `lag.rate`?"]);
    verify("\"lag.y\"", "\"lagy\"").is_mistake(&["study.toml:16:12", "did you mean `lag.y`?"]);
    let bench = Bench::new();
    let set = bench.run(&["simulate", "lag.fmu", "--set", "lag.lenght=1"]);
    set.is_mistake(&["lag.lenght", "did you mean `lag.length`?"]);
}

#[test]
fn wrong_units() {
    verify("mean = 1", "mean = \"1 mm\"").is_mistake(&["study.toml:10", "lag.rate", "`mm`", "1/s"]);
    let unit = "tolerance = 0.02\nunit = \"degC\"";
    verify("tolerance = 0.02", unit).is_mistake(&["study.toml:15", "`degC`"]);
    let bench = Bench::new();
    let set = bench.run(&["simulate", "lag.fmu", "--set", "lag.length=1 degC"]);
    set.is_mistake(&["`degC`", "use m, mm"]);
}

#[test]
fn values_that_make_no_sense() {
    let bench = Bench::new();
    let set = |text: &str| bench.run(&["simulate", "lag.fmu", "--set", text]);
    set("lag.length=-0.02 mm").is_mistake(&["lag.length", "less than the smallest value 0"]);
    set("lag.length=0,02 mm").is_mistake(&["`0,02 mm`", "write a point"]);
    set("lag.length=0").is_mistake(&["length 0 must be positive"]);
    set("lag.count=1.5").is_mistake(&["lag.count", "whole number"]);
    set("lag.flag=maybe").is_mistake(&["lag.flag", "neither true nor false"]);
    set("lag.fault=Flood").is_mistake(&["lag.fault", "Crash"]);
    set("lag.y=1").is_mistake(&["lag.y", "computed"]);
    set("lag.y").is_mistake(&["NAME=VALUE"]);
    verify("mean = 1", "mean = -1").is_mistake(&["study.toml:10", "less than the smallest"]);
    verify("deviation = 0.1", "deviation = 0").is_mistake(&["study.toml:10", "deviation"]);
    verify("stop = 2", "stop = -2").is_mistake(&["study.toml:5:1", "stop time"]);
    for (line, place) in [
        ("step = 5", "6:1"),
        ("warm-up = 3", "6:1"),
        ("window = 3", "6:1"),
        ("window = 1\nwarm-up = 1", "7:1"),
        ("tolerance = -1", "6:1"),
    ] {
        verify("stop = 2", &format!("stop = 2\n{line}")).is_mistake(&[&format!("study.toml:{place}: [simulation] ")]);
    }
    verify("points = 8", "points = 0").is_mistake(&["study.toml:8:1: [design] points"]);
    verify("points = 8", "seed = 1\nmethod = \"full-factorial\"")
        .is_mistake(&["study.toml:7:2: [design] a full factorial needs"]);
    verify("nominal = 0.86", "nominal = nan").is_mistake(&["study.toml:15", "not a finite number"]);
    for (option, value, remedy) in [
        ("--jobs", "0", "at least 1 is needed"),
        ("--points", "-1", "a whole number is needed, not negative"),
        ("--seed", "1e4", "a whole number is needed, not negative"),
    ] {
        let said = bench.run(&["verify", "study.toml", option, value]);
        said.is_mistake(&[&format!("invalid value '{value}'"), remedy]);
    }
    bench.write("study.toml", STUDY);
    bench
        .run(&["verify", "study.toml", "--points", "0"])
        .is_mistake(&["study.toml: --points 0: points must be at least 1"]);
    let never = bench.run(&["verify", "study.toml", "--point-timeout", "-1"]);
    never.is_mistake(&["--point-timeout: -1.0 s is not a positive time"]);
    let start = bench.run(&["simulate", "lag.fmu", "--start", "-1", "--stop", "0"]);
    assert_eq!(start.code, 0, "{}", start.err);
    assert!(start.out.lines().nth(1).unwrap().starts_with("-1,"));
}

#[test]
fn criteria_that_could_not_be_told_apart() {
    for name in ["point", "status", "lag.rate"] {
        let criterion = format!("[criteria.\"{name}\"]");
        verify("[criteria.Y]", &criterion).is_mistake(&["two columns", name, "rename"]);
    }
}

#[test]
fn more_workers_than_points_share_nothing() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let said = bench.run(&["verify", "study.toml", "--jobs", "100000"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(bench.summary("results/study")["run"]["jobs"], 8);
}

#[test]
fn why_points_fail_is_said() {
    let said = verify("[design]", "[fixed]\n\"lag.length\" = 0\n\n[design]");
    // Nothing was compared, so nothing is contradicted.
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.out.contains("\n8 points, 8 of them failed"), "{}", said.out);
    assert!(said.out.contains("point 1: fmi2Error: "), "{}", said.out);
    assert!(said.out.contains("length 0 must be positive"), "{}", said.out);
}

#[test]
fn what_a_study_costs() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let said = bench.run(&["verify", "study.toml", "--dry-run"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("in all: a point takes "), "{}", said.out);
    assert!(!bench.path("results").exists());
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let bench = Bench::new();
    // More than a pipe holds.
    let arguments = ["simulate", "lag.fmu", "--stop", "100", "--step", "0.001"];
    let mut child = bench.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let said: crate::support::Said = child.wait_with_output().unwrap().into();
    assert_eq!((said.code, said.err.as_str()), (0, ""));
}

#[test]
fn designs_that_cannot_be() {
    let design = |text: &str| verify("points = 8", text);
    design("method = \"full-factorial\"").is_mistake(&["`levels`"]);
    design("method = \"full-factorial\"\npoints = 8").is_mistake(&["study.toml:9:10", "remove `points`"]);
    design("method = \"optimised-latin-hypercube\"\npoints = 5000").is_mistake(&["at most 4096"]);
    let correlated = |text: &str| verify("[criteria.Y]", &format!("[[correlations]]\n{text}\n[criteria.Y]"));
    correlated("between = [\"lag.rate\", \"lag.rato\"]\ncoefficient = 0.5")
        .is_mistake(&["study.toml:16:24", "did you mean `lag.rate`?"]);
    correlated("between = [\"lag.rate\", \"lag.rate\"]\ncoefficient = 0.5").is_mistake(&["study.toml:15:1", "itself"]);
    correlated("between = [\"lag.rate\", \"lag.rate\"]\nrho = 0.5").is_mistake(&["study.toml:17:1", "`rho`"]);
    // What lies beyond the two would be lost.
    correlated("between = [\"lag.rate\", \"lag.length\", \"lag.y\"]\ncoefficient = 0.5").is_mistake(&[
        "study.toml:16:11",
        "a list of two",
        "has 3",
    ]);
    verify("deviation = 0.1", "deviation = 0.1\nlevels = 3").is_mistake(&["study.toml:14:10", "full-factorial"]);
}

#[test]
fn typing_errors_in_a_study() {
    verify("points = 8", "pionts = 8").is_mistake(&["study.toml:8:1", "did you mean `points`?"]);
    verify("points = 8", "points = ").is_mistake(&["study.toml:8:"]);
    verify("\"normal\"", "\"normall\"").is_mistake(&["study.toml:11:16", "`normal`"]);
    verify("deviation = 0.1", "min = 0.1").is_mistake(&["study.toml:10", "does not use `min`"]);
    verify("nominal = 0.86\n", "").is_mistake(&["study.toml:", "nominal"]);
    // Where a section is needed, none of the program's own words is said.
    verify("[criteria.Y]", "[inputs]\n\"drive.u\" = \"drive.csv\"\n[criteria.Y]")
        .is_mistake(&["study.toml:16:13", "{ file = \"drive.csv\" }"]);
}

#[test]
fn no_key_of_a_study_is_unread() {
    // Whichever command reads the study: line, column, and the nearest key.
    for (section, message) in [
        ("[sensitivity]\nbsae = 3", "unknown field `bsae`"),
        ("[sensitivity]\nsize = \"many\"", "expected a whole number"),
        ("[robustness]\nlevle = 0.8", "did you mean `level`?"),
        ("[identify]\nstrats = 3", "did you mean `starts`?"),
        ("[identify.free.\"lag.rate\"]\nmin = 1\nmax = 2\nscael = \"log\"", "did you mean `scale`?"),
    ] {
        let place = format!("study.toml:{}:", 18 + section.lines().count());
        verify("tolerance = 0.02", &format!("tolerance = 0.02\n{section}")).is_mistake(&[&place, message]);
    }
}

#[test]
fn options_of_a_run() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    for (options, parts) in [
        (["--memory-limit", "10"], ["`10` is not a size", "500MB"]),
        (["--launcher", "ssh {host}"], ["{host}", "--hosts FILE"]),
        (["-points", "10"], ["two hyphens", "--points"]),
    ] {
        bench.run(&[&["verify", "study.toml"][..], &options].concat()).is_mistake(&parts);
    }
}

#[test]
fn what_a_folder_does_not_hold() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    assert_eq!(bench.run(&["verify", "study.toml", "--output", "r"]).code, 0);
    bench.run(&["replay", "r", "99"]).is_mistake(&["r: the study has no point 99; points.csv lists its 8"]);
    bench.write("r/summary.json", "{\"title\":");
    bench.run(&["report", "r"]).is_mistake(&["r/summary.json: damaged (", "`verify STUDY --resume` writes it again"]);
    assert_eq!(bench.run(&["verify", "study.toml", "--output", "r", "--resume"]).code, 0);
    assert_eq!(bench.run(&["report", "r"]).code, 0);
}

#[test]
fn times_take_units_and_numbers_no_signs() {
    assert_eq!(verify("stop = 2", "stop = \"2000 ms\"").code, 0);
    verify("stop = 2", "stop = \"2 m\"").is_mistake(&["study.toml:5:", "`m` is no unit of time: use s, ms"]);
    verify("stop = 2", "stop = \"2 sec.\"").is_mistake(&["study.toml:5:", "`sec.` is no unit of time"]);
    verify("tolerance = 0.02", "tolerance = \"±2 %\"").is_mistake(&["write it without the sign, `2 %`"]);
    let far = verify("nominal = 0.86", "nominal = 1e300");
    assert!(far.code == 1 && !far.out.contains("00000000000000000000"), "{}", far.out);
}

#[test]
fn values_for_single_commands() {
    let bench = Bench::new();
    let say = |section: &str, command: &[&str]| {
        bench.write("study.toml", &format!("{STUDY}{section}\n"));
        bench.run(command)
    };
    let sensitivity = ["sensitivity", "study.toml"];
    say("[sensitivity]\nmethod = \"morris\"\nsize = 1", &sensitivity).is_mistake(&["study.toml:21:8", "1 is too few"]);
    say("[sensitivity]\nmethod = \"moris\"", &sensitivity).is_mistake(&[
        "study.toml:20:10",
        "`moris`",
        "sobol, morris",
    ]);
    say("[sensitivity]\nestimator = \"sobol\"", &sensitivity)
        .is_mistake(&["study.toml:20:13", "`combined`, `jansen` and `saltelli`"]);
    say("", &["sensitivity", "study.toml", "--method", "moris"]).is_mistake(&["--method", "sobol, morris"]);
    let estimator = ["--estimator", "jansen", "--morris", "4"];
    say("", &[&sensitivity[..], &estimator].concat()).is_mistake(&["--estimator", "morris has no estimators"]);
    say("[fixed]\n\"lag.length\" = [3]", &["verify", "study.toml"])
        .is_mistake(&["study.toml:20:", "a start value is a number"]);
    say("[robustness]\nlevel = 2", &["robustness", "study.toml"])
        .is_mistake(&["study.toml:20:9", "level must lie between 0 and 1"]);
}

#[test]
fn no_criteria() {
    let (before, _) = STUDY.split_once("[criteria").unwrap();
    let bench = Bench::new();
    bench.write("study.toml", before);
    bench.run(&["verify", "study.toml"]).is_mistake(&["study.toml", "no criteria"]);
    bench.write("table.csv", "Y\n1\n");
    bench.run(&["judge", "study.toml", "table.csv"]).is_mistake(&["no criteria"]);
}

#[test]
fn tables_that_do_not_fit() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let judge = |text: &str| {
        bench.write("table.csv", text);
        bench.run(&["judge", "study.toml", "table.csv"])
    };
    judge("point,Z\n1,0.8\n").is_mistake(&["table.csv", "no column `Y`", "point, Z"]);
    judge("point,Y\n1,high\n").is_mistake(&["table.csv:2", "`high` is not a number"]);
    judge("point;Y\n1;0,86\n2;1.000\n").is_mistake(&["table.csv:3", "`1.000`", "a decimal comma"]);
    judge("point;Y\n1;1.000\n2;0,86\n").is_mistake(&["table.csv:3", "`0,86`", "as in 1.000"]);
    judge("point,Y\n").is_mistake(&["table.csv", "no rows"]);
    judge("").is_mistake(&["table.csv", "no rows"]);
    judge("Y,Y\n1,2\n").is_mistake(&["table.csv", "column `Y` is there twice"]);
    judge("point,Y\n1,1\n1,2\n").is_mistake(&["table.csv", "point 1 is there twice"]);
    judge("point,Y\n1,1,3\n").is_mistake(&[
        "table.csv",
        "line 2 has 3 cells instead of 2",
        "a decimal comma needs semicolons between cells",
    ]);
    judge("1,0.8\n2,0.9\n").is_mistake(&["table.csv", "the first line must name the columns"]);
    std::fs::write(bench.path("table.csv"), b"point,Y,\xe9\n1,1,1\n").unwrap();
    let latin = bench.run(&["judge", "study.toml", "table.csv"]);
    latin.is_mistake(&["table.csv", "line 1", "UTF-8"]);
    let missing = bench.run(&["judge", "study.toml", "none.csv"]);
    missing.is_mistake(&["none.csv"]);
}

#[test]
fn tables_of_other_programs() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let judge = |text: &str| {
        bench.write("table.csv", text);
        let said = bench.run(&["judge", "study.toml", "table.csv"]);
        assert!(said.code < 2, "{}", said.err);
        said.out
    };
    // As a spreadsheet in German saves it.
    let said = judge("\u{feff}point;Y\r\n1;0,85\r\n2;\"0,9\"\r\n");
    assert!(said.contains("all criteria: verified                     1"), "{said}");
    // A point that failed in the other program counts as failed here, too.
    let said = judge("point,Y\n1,0.85\n2,\n3,nan\n");
    assert!(said.contains("\n3 points, 2 of them failed\n       2 as point 2: not finite: lag.y\n"), "{said}");
}

/// FMI 2.0.5, 2.2.7: a constant never changes, whatever its causality.
#[test]
fn a_constant_does_not_vary() {
    let bench = Bench::empty();
    for causality in ["local", "output"] {
        let constant = format!("causality=\"{causality}\" variability=\"constant\"");
        let description = model(
            "name=\"lag.rate\" valueReference=\"1\" causality=\"parameter\" variability=\"fixed\"",
            &format!("name=\"lag.rate\" valueReference=\"1\" {constant}"),
        );
        bench.fmu("lag.fmu", &[], &description);
        bench.write("study.toml", STUDY);
        let said = bench.run(&["verify", "study.toml"]);
        said.is_mistake(&[
            "study.toml:",
            "lag.rate",
            "it is a constant; only parameters, inputs and start values can be set",
        ]);
        assert_eq!(said.err.lines().count(), 1, "{}", said.err);
    }
}
