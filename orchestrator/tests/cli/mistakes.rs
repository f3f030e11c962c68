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
    bench.write("system.toml", &STUDY.replace("lag.fmu", "two.ssp"));
    for command in
        ["simulate two.ssp", "verify two.ssp", "init two.ssp", "inspect two.ssp", "check two.ssp", "verify system.toml"]
    {
        let said = bench.run(&command.split(' ').collect::<Vec<_>>());
        said.is_mistake(&["two.ssp", "a system of FMUs", "-m fmu_orchestrator system"]);
    }
    bench.run(&["verify", "system.toml"]).is_mistake(&["system.toml:2:7: "]);
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
    design("method = \"full-factorial\"").is_mistake(&["study.toml:8:10", "`full-factorial`"]);
    design("method = \"monte-carlo\"\nreplicates = 2").is_mistake(&["replicates need method = sobol"]);
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

/// Slips of the pen, each with its place and what to do.
#[test]
fn slips_in_a_study() {
    let bench = Bench::new();
    bench.write("in.csv", "time,u,late,text\n0,1,1,1\n1,1,2,#DIV/0!\n2,1,3,1\n");
    let slips = [
        ("stop = 2", "stop = true", "5:8", "expected a number"),
        ("stop = 2", "stop = inf", "5:1", "must be later than the start"),
        ("stop = 2", "start = 3\nstop = 2", "6:1", "must be later than the start 3.0 s"),
        ("stop = 2", "stop = 2\nstep = \"fast\"", "6:8", "`fast` is not a number, or a number with a unit"),
        ("stop = 2", "stop = 2\nstep = 1e-12", "6:1", "absurdly small"),
        ("stop = 2", "end = 2", "5:1", "expected one of `start`, `stop`"),
        ("points = 8", "points = 8.5", "8:10", "expected a whole number"),
        ("points = 8", "points = \"8\"", "8:10", "expected a whole number"),
        ("points = 8", "points = 8\nmethod = \"random\"", "9:10", "did you mean `monte-carlo`?"),
        ("points = 8", "points = 8\npoints-from = \"a.csv\"", "9:1", "did you mean `points`?"),
        ("points = 8", "points = 8\nseed = -1", "9:8", "expected a whole number, not negative"),
        ("[design]", "[Design]", "7:2", "did you mean `design`?"),
        ("[criteria.Y]", "[criterion.Y]", "15:2", "did you mean `criteria`?"),
        ("[criteria.Y]", "[criteria]", "16:12", "a section with a name, [criteria.NAME]"),
        ("[criteria.Y]", "[criteria.\"\"]", "15:11", "needs a name"),
        ("[parameters.\"lag.rate\"]", "[parameters.lag_rate]", "10:13", "did you mean `lag.rate`?"),
        ("[parameters.\"lag.rate\"]", "[parameters.\"lag.y\"]", "10:13", "it is computed by the FMU; only parameters"),
        ("mean = 1", "mean = \"1 m/s\"", "10:13", "the value is in 1/s; use 1/s"),
        ("mean = 1", "mean = \"one\"", "12:8", "`one` is not a number"),
        ("mean = 1", "mean = inf", "10:13", "not a finite number"),
        ("deviation = 0.1", "deviation = nan", "10:13", "must be positive"),
        ("deviation = 0.1", "variance = 0.01", "13:1", "did you mean `deviation`?"),
        ("\"normal\"", "\"uniform\"\nmin = 2\nmax = 1", "10:13", "does not use `mean`; it takes min, max"),
        ("\"normal\"", "\"Normal\"", "11:16", "did you mean `normal`?"),
        ("\"normal\"", "3", "11:16", "expected a text in quotes"),
        ("\"normal\"", "\"sample\"", "10:13", "does not use `mean`; it takes file"),
        ("distribution = \"normal\"\n", "", "10:1", "missing: `distribution`"),
        ("variable = \"lag.y\"\n", "", "15:1", "missing: `variable`"),
        ("variable = \"lag.y\"", "variable = \"lag.rate\"", "16:12", "remove the criterion or name an output"),
        ("variable = \"lag.y\"", "variables = \"lag.y\"", "16:1", "did you mean `variable`?"),
        ("variable = \"lag.y\"", "variable = \u{201c}lag.y\u{201d}", "16:12", "straight quotes"),
        ("nominal = 0.86", "nominal = 3018 // rpm", "17:11", "a comment begins with #"),
        ("nominal = 0.86", "nominal\u{a0}= 0.86", "17:8", "each line of a study is `key = value`"),
        ("nominal = 0.86", "nominal = \"0,86\"", "17:11", "write a point in the number instead of the comma"),
        ("nominal = 0.86", "nominal = \"0.86 mm\"", "15:11", "use 1, %; give the number alone"),
        ("nominal = 0.86", "value = 0.86", "17:1", "did you mean `nominal`?"),
        ("tolerance = 0.02", "tolerance = 0", "15:11", "must be a positive, finite number"),
        ("tolerance = 0.02", "tolerance = [0.1, 0.2]", "18:13", "{ minus = \"1 mm\", plus = \"2 mm\" }"),
        ("tolerance = 0.02", "tolerance = { minus = 1 }", "18:13", "{ minus = \"1 mm\", plus = \"2 mm\" }"),
        (
            "tolerance = 0.02",
            "tolerance = \"2 percent\"",
            "15:11",
            "unit `percent` is not known: the value is in no unit; use 1, %",
        ),
        ("tolerance = 0.02", "", "15:11", "add `tolerance`, such as \"0.5 %\""),
        ("tolerance = 0.02", "tolerance = 0.02\nstatistic = \"average\"", "19:13", "did you mean `mean`?"),
        ("tolerance = 0.02", "tolerance = 0.02\nstatistic = \"percentile\"", "15:11", "such as percent = 95"),
        ("tolerance = 0.02", "tolerance = 0.02\npercent = 5", "15:11", "add that, or remove `percent`"),
        ("tolerance = 0.02", "tolerance = 0.02\nwindow = 5", "19:10", "must lie between start and stop, 0 s and 2 s"),
        ("tolerance = 0.02", "tolerance = 0.02\nwindow = \"1 m\"", "19:10", "use s, ms, min or h"),
        ("tolerance = 0.02", "tolerance = 0.02\nuncertainty = -0.1", "19:15", "must be a positive, finite number"),
        ("tolerance = 0.02", "tolerance = 0.02\ncoverage = 2", "19:12", "add `uncertainty` or remove it"),
        ("tolerance = 0.02", "tolerance = 0.02\nmetric = \"rmse\"", "15:11", "add `reference`, or remove `metric`"),
        ("tolerance = 0.02", "tolerance = 0.02\nat-most = 1", "15:11", "keep one of them"),
        ("tolerance = 0.02", "tolerance = 0.02\nreference = \"m.csv\"", "19:13", "{ key = value }"),
        ("tolerance = 0.02", "tolerance = 0.02\nunit = 3", "19:8", "expected a text in quotes"),
        ("tolerance = 0.02", "tolerance = 0.02\n[verdict]\nshare = 5", "20:9", "such as \"5 %\" or 0.05"),
        ("tolerance = 0.02", "tolerance = 0.02\n[verdict]\nrisk = \"5 %\"", "19:1", "share = \"90 %\""),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[verdict]\nshare = 0.5\nconfidence = 95",
            "21:14",
            "at least 0.5 and below 1",
        ),
        ("tolerance = 0.02", "tolerance = 0.02\n[fixed]\n\"lag.rate\" = 1", "20:1", "keep one"),
        ("tolerance = 0.02", "tolerance = 0.02\n[fixed]\n\"lag.length\" = \"1 kg\"", "20:16", "use m, mm"),
        ("tolerance = 0.02", "tolerance = 0.02\n[inputs.\"drive.u\"]\nfile = \"none.csv\"", "20:8", "no such file"),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[inputs.\"drive.u\"]\nfile = \"in.csv\"\ncolumm = \"u\"",
            "21:1",
            "did you mean `column`?",
        ),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[inputs.\"drive.u\"]\nfile = \"in.csv\"\ncolumn = \"v\"",
            "20:8",
            "it has time, u, late, text",
        ),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[inputs.\"drive.u\"]\nfile = \"in.csv\"\ncolumn = \"text\"",
            "20:8",
            "a spreadsheet's error: leave the cell empty",
        ),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[inputs.\"drive.u\"]\nfile = \"in.csv\"\ntime = \"late\"\ncolumn = \"u\"",
            "19:9",
            "set start = 1, or write extrapolate",
        ),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[[cases]]\nname = \"a\"\nheld_out = true",
            "21:1",
            "did you mean `held-out`?",
        ),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[[cases]]\nname = \"a\"\nfixed = { \"lag.rate\" = 2 }",
            "21:11",
            "remove it there or from the case `a`",
        ),
        ("tolerance = 0.02", "tolerance = 0.02\n[[cases]]\nname = \"a/b\"", "20:8", "without `/`"),
        (
            "tolerance = 0.02",
            "tolerance = 0.02\n[identify]\nfree = [\"lag.rate\"]",
            "20:8",
            "expected a section with keys",
        ),
    ];
    for (from, to, place, remedy) in slips {
        assert!(STUDY.contains(from), "{from}");
        bench.write("study.toml", &STUDY.replace(from, to));
        bench.run(&["verify", "study.toml"]).is_mistake(&[&format!("study.toml:{place}: "), remedy]);
    }
}

#[test]
fn slips_in_a_command() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    bench.write("in.csv", "time,u\n0,1\n2,1\n");
    for (command, remedy) in [
        ("verify study.toml --point 8", "a similar argument exists: '--points'"),
        ("verify study.toml --point-timeout 5s", "without a unit"),
        ("verify study.toml --shard 3/2", "not a part such as 2/8"),
        ("verify study.toml --extra-runs -1", "unexpected argument '-1' found; --help"),
        ("verify study.toml --resume --force", "'--resume' cannot be used with '--force'"),
        ("verify study.toml --fmu study.toml", "a study, where an FMU is needed"),
        ("verify study.toml --until soon", "\"ci 0.01\""),
        ("verify study.toml --budget 3", "20 to 1000 runs"),
        (
            "verify study.toml --isolation none --points-from in.csv",
            "no column `lag.rate` for the parameter lag.rate; it has time, u",
        ),
        ("verify .", "a folder; give a file"),
        ("verfy study.toml", "a similar subcommand exists: 'verify'"),
        ("judge study.toml", "<TABLE>"),
        ("simulate lag.fmu --set =1", "no variable"),
        ("simulate lag.fmu --input in.csv", "column `u`: the FMU has no variable `u`; did you mean `drive.u`?"),
        ("replay nowhere 1", "run `verify` into it first"),
        ("compare nowhere", "<NEW>"),
        ("check lag.fmu --step 0", "a positive, finite number of seconds"),
        ("init lag.fmu --output study.toml", "exists already; choose another name"),
        ("sensitivity study.toml --base 16 --morris 4", "cannot be used with"),
        ("identify study.toml", "add `uncertainty`"),
        ("pack study.toml --output lag.fmu", "choose another name"),
    ] {
        bench.run(&command.split(' ').collect::<Vec<_>>()).is_mistake(&[remedy]);
    }
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
    let bench = Bench::new();
    for key in ["starts", "descents", "iterations"] {
        let section = format!("tolerance = 0.02\nuncertainty = 0.01\n[identify]\n{key} = 0");
        bench.write("study.toml", &STUDY.replace("tolerance = 0.02", &section));
        let said = bench.run(&["identify", "study.toml"]);
        said.is_mistake(&[&format!("study.toml:21:1: [identify] {key} must be 1 or more")]);
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
    bench.run(&["report", "r"]).is_mistake(&["r/summary.json: damaged (", "`--output r --resume` writes it again"]);
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
    let convert = "`python -m fmu_orchestrator convert \"table.csv\"`";
    judge("point,Y\n1,high\n").is_mistake(&["table.csv:2", "`high` is not a number", convert]);
    judge("point,Y\n1,0.8 m/s\n").is_mistake(&["table.csv:2", "units belong behind the column's name", convert]);
    judge("point;Y\n1;0,86\n2;1.000\n").is_mistake(&[
        "table.csv:3: column `Y`",
        "`1.000` may be 1000 or 1.000",
        "--decimal",
    ]);
    judge("point;Y\n1;1.000\n2;0,86\n").is_mistake(&[
        "table.csv:2: column `Y`",
        "`1.000` may be 1000 or 1.000",
        "--decimal",
    ]);
    judge("point;t;Y\n1;0.5;1.000\n").is_mistake(&["table.csv:2: column `Y`", "`1.000` may be 1000 or 1.000"]);
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
    latin.is_mistake(&["table.csv", "line 1", "UTF-8", convert]);
    let missing = bench.run(&["judge", "study.toml", "none.csv"]);
    missing.is_mistake(&["none.csv"]);
}

/// The table has what the model gave: `judge` alone needs no FMU.
#[test]
fn a_study_without_a_model() {
    let bench = Bench::new();
    bench.write("study.toml", &STUDY.replace("fmu = \"lag.fmu\"", ""));
    bench.write("table.csv", "point,Y\n1,0.85\n2,0.9\n");
    for _ in 0..2 {
        let said = bench.run(&["judge", "study.toml", "table.csv", "--output", "r"]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    assert_eq!(bench.summary("r")["verified"], 1);
    assert_eq!(bench.run(&["report", "r"]).code, 0);
    for command in ["verify", "identify", "sensitivity"] {
        let said = bench.run(&[command, "study.toml"]);
        said.is_mistake(&["study.toml: names no FMU: add fmu = \"my.fmu\""]);
    }
    assert_eq!(bench.run(&["verify", "study.toml", "--fmu", "lag.fmu"]).code, 0);
}

/// What a study and a command line say, and what nobody can mean by it.
#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    let bench = Bench::new();
    bench.write("run.csv", "time,lag.y\n0,0\n1,0.63\n2,0.86\n");
    let curve = "reference = { file = \"run.csv\" }\nmetric = \"rmse\"\ntolerance = 0.02\n";
    let single = "nominal = 0.86\ntolerance = 0.02\n";
    let late = format!("{curve}lag = {{ min = 1, max = 0 }}\n");
    let case = "[[cases]]\nname = \"a\"\nlag = { min = 1, max = 0 }\n[criteria.Y]";
    for (from, to, told) in [
        ("\"lag.fmu\"", "\"\"", ["study.toml:2:7: it is empty", "fmu = \"my.fmu\""]),
        (single, &late, ["study.toml:15:11: Y: the lags from 1 to 0", "`min` is the smaller one"]),
        ("[criteria.Y]", case, ["study.toml:16:8: case a: the lags from 1 to 0", "`min` is the smaller one"]),
    ] {
        bench.write("study.toml", &STUDY.replace(from, to));
        bench.run(&["verify", "study.toml"]).is_mistake(&told);
    }
    bench.write("study.toml", STUDY);
    bench
        .run(&["verify", "study.toml", "--dry-run", "--junit", "j.xml"])
        .is_mistake(&["--junit: --dry-run has no verdict"]);
    for text in ["", "\n\n"] {
        bench.write("empty.csv", text);
        let said = bench.run(&["init", "lag.fmu", "--measured", "empty.csv", "--output", "new.toml"]);
        said.is_mistake(&["empty.csv: it is empty", "`time,speed [rpm]`"]);
    }
    bench.run(&["verify", "study.toml", "--output", "few"]);
    let said = bench.run(&["sensitivity", "study.toml", "--from", "few"]);
    said.is_mistake(&["--from: 8 points in few have values, and 12 are needed", "--resume --points 12"]);
    assert!(!bench.path("few/sensitivity.json").exists());
    // What it says, it keeps.
    bench.run(&["verify", "study.toml", "--output", "few", "--resume", "--points", "12"]);
    let advises =
        || bench.read("few/report.html").contains("<code>orchestrator sensitivity study.toml --from few</code>");
    assert!(advises());
    assert_eq!(bench.run(&["sensitivity", "study.toml", "--from", "few"]).code, 0);
    // It needs no advice any more.
    assert!(!advises());
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
