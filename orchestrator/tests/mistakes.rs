//! Every mistake of a user is answered by one clear line and exit code 2.

mod support;

use support::{Bench, model};

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
fn verify(from: &str, to: &str) -> support::Said {
    let bench = Bench::new();
    assert!(STUDY.contains(from));
    bench.write("study.toml", &STUDY.replace(from, to));
    bench.run(&["verify", "study.toml"])
}

#[test]
fn the_study_itself_is_right() {
    let said = verify("", "");
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn no_such_file() {
    let bench = Bench::empty();
    bench
        .run(&["inspect", "none.fmu"])
        .is_mistake(&["none.fmu: no such file"]);
    bench
        .run(&["verify", "none.toml"])
        .is_mistake(&["none.toml: no such file"]);
    verify("lag.fmu", "lost.fmu").is_mistake(&["lost.fmu: no such file"]);
}

#[test]
fn not_a_zip() {
    let bench = Bench::empty();
    bench.write("text.fmu", "This is not a zip.");
    bench
        .run(&["inspect", "text.fmu"])
        .is_mistake(&["text.fmu", "not a zip"]);
    bench.zip("other.fmu", &[("readme.txt", b"hello")]);
    bench
        .run(&["simulate", "other.fmu"])
        .is_mistake(&["other.fmu", "no modelDescription.xml"]);
}

#[test]
fn not_fmi_2() {
    let bench = Bench::empty();
    bench.fmu(
        "three.fmu",
        &[],
        &model("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\""),
    );
    bench
        .run(&["inspect", "three.fmu"])
        .is_mistake(&["three.fmu", "FMI 3.0", "FMI 2.0 is needed"]);
}

#[test]
fn no_co_simulation() {
    let bench = Bench::empty();
    bench.fmu("me.fmu", &[], &model("<CoSimulation", "<ModelExchange"));
    bench
        .run(&["simulate", "me.fmu"])
        .is_mistake(&["me.fmu", "no Co-Simulation"]);
}

#[test]
fn no_binary_for_this_platform() {
    let bench = Bench::empty();
    let description = model("", "");
    let entries: [(&str, &[u8]); 2] = [
        ("modelDescription.xml", description.as_bytes()),
        ("binaries/win64/lag.dll", b""),
    ];
    bench.zip("windows.fmu", &entries);
    bench
        .run(&["simulate", "windows.fmu"])
        .is_mistake(&["windows.fmu", "platform", "win64"]);
    // What it is can be said all the same.
    assert_eq!(bench.run(&["inspect", "windows.fmu"]).code, 0);
}

#[test]
fn a_damaged_binary() {
    let bench = Bench::empty();
    let description = model("", "");
    let entries: [(&str, &[u8]); 2] = [
        ("modelDescription.xml", description.as_bytes()),
        ("binaries/linux64/lag.so", b"junk"),
    ];
    bench.zip("junk.fmu", &entries);
    bench
        .run(&["simulate", "junk.fmu"])
        .is_mistake(&["junk.fmu", "cannot load"]);
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
    set("lag.length=0").is_mistake(&["length 0 must be positive"]);
    set("lag.count=1.5").is_mistake(&["lag.count", "whole number"]);
    set("lag.flag=maybe").is_mistake(&["lag.flag", "neither true nor false"]);
    set("lag.fault=Flood").is_mistake(&["lag.fault", "Crash"]);
    set("lag.y=1").is_mistake(&["lag.y", "computed"]);
    set("lag.y").is_mistake(&["NAME=VALUE"]);
    verify("mean = 1", "mean = -1").is_mistake(&["study.toml:10", "less than the smallest"]);
    verify("deviation = 0.1", "deviation = 0").is_mistake(&["study.toml:10", "deviation"]);
    verify("stop = 2", "stop = -2").is_mistake(&["stop time"]);
    verify("points = 8", "points = 0").is_mistake(&["points"]);
}

#[test]
fn designs_that_cannot_be() {
    let design = |text: &str| verify("points = 8", text);
    design("method = \"full-factorial\"").is_mistake(&["`levels`"]);
    design("method = \"full-factorial\"\npoints = 8")
        .is_mistake(&["study.toml:9:10", "remove `points`"]);
    design("method = \"optimised-latin-hypercube\"\npoints = 5000").is_mistake(&["at most 4096"]);
    let correlated = |text: &str| {
        verify(
            "[criteria.Y]",
            &format!("[[correlations]]\n{text}\n[criteria.Y]"),
        )
    };
    correlated("between = [\"lag.rate\", \"lag.rato\"]\ncoefficient = 0.5")
        .is_mistake(&["study.toml:16:24", "did you mean `lag.rate`?"]);
    correlated("between = [\"lag.rate\", \"lag.rate\"]\ncoefficient = 0.5")
        .is_mistake(&["study.toml:15:1", "itself"]);
    correlated("between = [\"lag.rate\", \"lag.rate\"]\nrho = 0.5")
        .is_mistake(&["study.toml:17:1", "`rho`"]);
}

#[test]
fn typing_errors_in_a_study() {
    verify("points = 8", "pionts = 8").is_mistake(&["study.toml:8:1", "did you mean `points`?"]);
    verify("points = 8", "points = ").is_mistake(&["study.toml:8:"]);
    verify("\"normal\"", "\"normall\"").is_mistake(&["study.toml:11:16", "`normal`"]);
    verify("deviation = 0.1", "min = 0.1").is_mistake(&["study.toml:10", "does not use `min`"]);
    verify("nominal = 0.86\n", "").is_mistake(&["study.toml:", "nominal"]);
}

#[test]
fn no_criteria() {
    let (before, _) = STUDY.split_once("[criteria").unwrap();
    let bench = Bench::new();
    bench.write("study.toml", before);
    bench
        .run(&["verify", "study.toml"])
        .is_mistake(&["study.toml", "no criteria"]);
    bench.write("table.csv", "Y\n1\n");
    bench
        .run(&["judge", "study.toml", "table.csv"])
        .is_mistake(&["no criteria"]);
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
    judge("point,Y\n").is_mistake(&["table.csv", "no rows"]);
    let missing = bench.run(&["judge", "study.toml", "none.csv"]);
    missing.is_mistake(&["none.csv"]);
}
