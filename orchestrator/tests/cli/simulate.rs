//! `simulate` and `init` with FMUs of others: what is recorded, what is fed, and what the standard allows.

use crate::support::{Bench, Said, model};

fn rows(csv: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    csv.lines().map(cells).collect()
}

fn good(said: Said) -> Said {
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    said
}

/// The step is the program's own, as the description has none: whoever reads the message can set another.
#[test]
fn a_step_that_nobody_suggested_may_be_refused() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["REFUSES"], &model(" stepSize=\"0.01\"", ""));
    bench
        .run(&["simulate", "lag.fmu"])
        .is_mistake(&["fmi2Discard", "the step is 0.004 s, as the FMU suggests none; set another by --step"]);
    good(bench.run(&["simulate", "lag.fmu", "--step", "0.5"]));
}

/// The rows before it are whole, and the message is the FMU's.
#[test]
fn a_value_that_cannot_be_read_ends_the_simulation() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["MUTE=0.6"], &model("", ""));
    let run = ["simulate", "lag.fmu", "--stop", "1", "--step", "0.25"];
    let said = bench.run(&[&run[..], &["--output", "a.csv"]].concat());
    said.is_mistake(&["fmi2GetReal", "fmi2Error"]);
    let table = rows(&bench.read("a.csv"));
    let times: Vec<&str> = table.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(times, ["time", "0", "0.25", "0.5"]);
    assert!(table.iter().all(|row| row.len() == table[0].len()), "{table:?}");
}

#[test]
fn an_early_end_is_a_whole_simulation() {
    let bench = Bench::new();
    let said = good(bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=End", "--stop", "1", "--step", "0.3"]));
    let table = rows(&said.out);
    let times: Vec<&str> = table.iter().map(|row| row[0].as_str()).collect();
    // The step from 0.3 is refused at 0.5.
    assert_eq!(times, ["time", "0", "0.3", "0.5"]);
    assert!(said.err.contains("ended the simulation at 0.5 s"), "{}", said.err);
    let study = "title = \"x\"\nfmu = \"lag.fmu\"\n[simulation]\nstop = 1\nstep = 0.125\n[design]\nmethod = \"sobol\"\n\
        points = 4\nseed = 1\n[fixed]\n\"lag.fault\" = \"End\"\n[parameters.\"lag.rate\"]\ndistribution = \"uniform\"\n\
        min = 1\nmax = 2\n[criteria.MEAN]\nvariable = \"lag.y\"\nstatistic = \"mean\"\nnominal = 1\ntolerance = 9\n\
        [criteria.END]\nvariable = \"lag.y\"\nnominal = 1\ntolerance = 9\n";
    bench.write("study.toml", study);
    // Up to its end it is the simulation that stops there.
    let ended = good(bench.run(&["verify", "study.toml", "--output", "ended"]));
    assert!(!ended.out.contains("failed: "), "{}", ended.out);
    let shorter = study.replace("stop = 1\n", "stop = 0.5\n").replace("\"End\"", "\"None\"");
    bench.write("shorter.toml", &shorter);
    good(bench.run(&["verify", "shorter.toml", "--output", "shorter"]));
    let [ended, shorter] = ["ended", "shorter"].map(|folder| bench.read(&format!("{folder}/points.csv")));
    let values = |csv: &str| rows(csv).into_iter().map(|row| row[..4].to_vec()).collect::<Vec<_>>();
    // The refused step advanced the state once more in this FMU, so only the first value of the mean is compared.
    assert_eq!(values(&ended).len(), values(&shorter).len());
    assert!(rows(&ended)[1..].iter().all(|row| !row[2].is_empty() && row.last().unwrap().starts_with("ok")));
    // Before its window there is nothing to take a mean of.
    bench.write("late.toml", &study.replace("step = 0.125\n", "step = 0.125\nwarm-up = 0.75\n"));
    let late = bench.run(&["verify", "late.toml", "--output", "late"]);
    assert_eq!(late.code, 3, "{}{}", late.out, late.err);
    assert!(bench.read("late/points.csv").contains("before the window of the statistics"));
}

#[test]
fn what_a_run_says_beside_its_values_is_told() {
    let bench = Bench::new();
    let said = good(bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Warn"]));
    let words = "warnings of the FMU: 1; the first: fmi2DoStep: take care";
    assert!(said.err.contains(words), "{}", said.err);
    bench.fmu("endless.fmu", &["FAILING_TERMINATE"], &model("guid", "guid"));
    let said = good(bench.run(&["simulate", "endless.fmu"]));
    assert!(said.err.contains("its end failed: fmi2Error: fmi2Terminate"), "{}", said.err);
    let said = bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Pend"]);
    said.is_mistake(&["fmi2Pending", "fmi2GetStatus returned fmi2Discard"]);
}

#[test]
fn any_variable_is_recorded() {
    let bench = Bench::new();
    let said = good(bench.run(&[
        "simulate",
        "lag.fmu",
        "--record",
        "lag.count,drive.u",
        "--record",
        "lag.y",
        "--output",
        "-",
        "--stop",
        "0.02",
    ]));
    let table = rows(&said.out);
    assert_eq!(table[0], ["time", "lag.count", "drive.u", "lag.y"]);
    assert_eq!(table[1], ["0", "1", "1", "0"]);
    assert_eq!(table.len(), 4);
    bench.run(&["simulate", "lag.fmu", "--record", "lag.z"]).is_mistake(&["--record", "did you mean"]);
}

#[test]
fn inputs_follow_a_table() {
    let bench = Bench::new();
    bench.write("drive.csv", "time;drive.u\n0;0\n1;10\n");
    let command = ["simulate", "lag.fmu", "--record", "drive.u", "--stop", "1", "--step", "0.5", "--input"];
    let with = |file| bench.run(&[&command[..], &[file]].concat());
    let table = rows(&good(with("drive.csv")).out);
    // A value holds for the step that begins with it.
    let values: Vec<&str> = table.iter().map(|row| row[1].as_str()).collect();
    assert_eq!(values, ["drive.u", "0", "0", "5"]);
    bench.write("length.csv", "time,lag.length [mm]\n0,0.5\n");
    let length =
        |fmu| bench.run(&["simulate", fmu, "--record", "lag.length", "--input", "length.csv", "--extrapolate", "hold"]);
    // FMI 2.0.5, 4.2.4: only inputs and tunable parameters change while the simulation runs.
    length("lag.fmu").is_mistake(&["length.csv", "lag.length", "fixed parameter"]);
    let fixed = "valueReference=\"2\" causality=\"parameter\" variability=\"fixed\"";
    let tunable = model(fixed, &fixed.replace("fixed", "tunable"));
    bench.fmu("tunable.fmu", &[], &tunable);
    let said = good(length("tunable.fmu"));
    assert_eq!(rows(&said.out)[1][1], "0.0005");
    bench.write("other.csv", "time,drive.v\n0,0\n");
    with("other.csv").is_mistake(&["--input", "drive.v", "did you mean"]);
    bench.write("none.csv", "time\n0\n");
    with("none.csv").is_mistake(&["no column beside `time`"]);
    bench.write("back.csv", "time,drive.u\n1,0\n0,1\n");
    with("back.csv").is_mistake(&["`time` falls from 1 to 0 in row 2"]);
}

#[test]
fn inputs_cover_the_run_or_are_told_to_hold() {
    let bench = Bench::new();
    bench.write("drive.csv", "time,drive.u\n0,0\n0.05,10\n");
    bench.write("late.csv", "time,drive.u\n0.5,0\n5,10\n");
    let command = ["simulate", "lag.fmu", "--record", "drive.u", "--stop", "5", "--input"];
    let with = |more: &[&str]| bench.run(&[&command[..], more].concat());
    with(&["drive.csv"]).is_mistake(&[
        "drive.csv: column `drive.u`: the recording covers 0 s .. 0.05 s, the run goes from 0 s to 5 s",
        "so 0.05 s .. 5 s is missing",
        "--stop 0.05",
        "--extrapolate hold",
    ]);
    with(&["late.csv"]).is_mistake(&["0 s .. 0.5 s is missing", "--start 0.5"]);
    let table = rows(&good(with(&["drive.csv", "--extrapolate", "hold"])).out);
    assert_eq!(table.last().unwrap()[1], "10");
    good(with(&["late.csv", "--extrapolate", "hold"]));
}

#[test]
fn a_step_beyond_the_run_is_a_mistake() {
    let bench = Bench::new();
    let run = |more: &[&str]| bench.run(&[&["simulate", "lag.fmu", "--stop", "1"], more].concat());
    run(&["--step", "2"]).is_mistake(&["--step", "the step 2.0 s is longer than the run from 0.0 s to 1.0 s"]);
    good(run(&["--step", "1"]));
    // The step that the FMU suggests is cut to the run.
    let said = good(bench.run(&["simulate", "lag.fmu", "--stop", "0.001"]));
    assert_eq!(rows(&said.out).len(), 3);
}

/// A number without a unit is in the variable's unit, which is not the one that tools show.
#[test]
fn the_unit_of_a_bare_number_is_shown() {
    let bench = Bench::new();
    let said = good(bench.run(&["inspect", "lag.fmu"]));
    assert!(said.out.contains("  2e-5 m (0.02 mm)"), "{}", said.out);
    assert!(said.out.contains("  K (degC)"), "{}", said.out);
    let set = |value: &str| {
        let set = format!("lag.length={value}");
        good(bench.run(&["simulate", "lag.fmu", "--set", &set, "--stop", "0.01"])).err
    };
    let told = "lag.length = 0.02 m; its display unit is mm: write \"0.02 mm\" for that\n";
    assert_eq!(set("0.02"), told);
    for value in ["0.02 mm", "0.02 m"] {
        assert_eq!(set(value), "", "{value}");
    }
}

/// Without outputs: the same FMU with what it computes as local variables.
fn without_outputs() -> String {
    let text = model("causality=\"output\"", "causality=\"local\"");
    let (before, rest) = text.split_once("<ModelStructure>").unwrap();
    let after = rest.split_once("</ModelStructure>").unwrap().1;
    format!("{before}<ModelStructure/>{after}")
}

#[test]
fn without_outputs_the_inside_is_shown() {
    let bench = Bench::empty();
    bench.fmu("inner.fmu", &[], &without_outputs());
    let said = good(bench.run(&["simulate", "inner.fmu", "--stop", "0.01"]));
    let header = &rows(&said.out)[0];
    assert_eq!(header[..3], ["time", "lag.y", "lag.temperature"]);
    assert!(said.err.contains("no outputs, so its 4 local variables"), "{}", said.err);
    let study = good(bench.run(&["init", "inner.fmu"])).out;
    assert!(study.contains("variable = \"lag.y\""), "{study}");
}

#[test]
fn no_cell_becomes_a_formula() {
    let bench = Bench::empty();
    bench.fmu("sly.fmu", &[], &model("name=\"lag.y\"", "name=\"=1+1\""));
    let said = good(bench.run(&[
        "simulate",
        "sly.fmu",
        "--record",
        "=1+1,lag.text,lag.count",
        "--set",
        "lag.text=@SUM(A1)",
        "--stop",
        "0.01",
    ]));
    let table = rows(&said.out);
    assert_eq!(table[0], ["time", "'=1+1", "'lag.text", "lag.count"].map(|name| name.replace("'lag", "lag")));
    assert_eq!(table[1][2], "'@SUM(A1)");
    // Numbers stay numbers.
    assert_eq!((table[1][1].as_str(), table[1][3].as_str()), ("0", "1"));
}

/// The instance is freed after the last row: what goes wrong there takes nothing away.
#[test]
fn a_crash_at_the_end_is_told_and_costs_nothing() {
    let bench = Bench::new();
    bench.fmu("freeing.fmu", &["DOUBLE_FREE"], &model("", ""));
    let [sound, freeing] =
        ["lag.fmu", "freeing.fmu"].map(|fmu| good(bench.run(&["simulate", fmu, "--record", "lag.y"])));
    assert_eq!(freeing.out, sound.out);
    for words in ["its end failed", "SIGABRT", "fmi2FreeInstance"] {
        assert!(freeing.err.contains(words), "{}", freeing.err);
    }
    assert!(!sound.err.contains("its end failed"));
}
