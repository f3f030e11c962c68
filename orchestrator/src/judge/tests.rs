use super::*;
use fmu_points::failure::OfCase;
use std::path::Path;

const STUDY: &str = r#"
    fmu = "a.fmu"
    [criteria.T]
    variable = "t"
    nominal = 82
    tolerance = "0.75 %"
    unit = "degC"
    group = "temperature"
    [criteria.F]
    variable = "f"
    nominal = "750 N"
    tolerance = "7 %"
    unit = "N"
    [variants.absolute]
    tolerance.T = "0.75 degC"
"#;

fn judge(text: &str) -> Result<Judge, String> {
    let study = Study::parse(Path::new("s.toml"), text.to_owned());
    let study = study.map_err(|error| error.to_string())?;
    Judge::new(&study, None).map_err(|error| error.to_string())
}

#[test]
fn percents_are_of_the_nominal_value_as_printed() {
    let judge = judge(STUDY).unwrap();
    assert!((judge.criteria[0].tolerance - 0.615).abs() < 1e-12);
    assert!((judge.criteria[1].tolerance - 52.5).abs() < 1e-12);
    assert!(judge.verdict(Some(&[81.39, 697.5])).verified());
    assert!(!judge.verdict(Some(&[81.33, 700.0])).verified());
    let absolute = &judge.variants[0];
    assert!(
        judge
            .variant_verdict(absolute, Some(&[81.33, 700.0]))
            .verified()
    );
}

/// A part of a value in a unit with another zero depends on the unit in which the value is written.
#[test]
fn percents_count_in_the_unit_in_which_the_value_is_written() {
    let fmu = r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
        <UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/>
        <DisplayUnit name="mK" factor="1000"/></Unit></UnitDefinitions>
        <ModelVariables><ScalarVariable name="t" valueReference="0" causality="output"><Real unit="K"/>
        </ScalarVariable></ModelVariables><ModelStructure/></fmiModelDescription>"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("modelDescription.xml"), fmu).unwrap();
    let package = fmu_import::Package::open(folder.path()).unwrap();
    let fmu = package.description();
    let of = |nominal: &str, unit: &str| {
        let text = format!(
            "fmu = \"a\"\n[criteria.T]\nvariable = \"t\"\nnominal = {nominal}\ntolerance = \"1 %\"\n\
             uncertainty = \"0.5 %\"\n{unit}\n[variants.wide]\ntolerance.T = \"2 %\"\n"
        );
        let study = Study::parse(Path::new("s.toml"), text).unwrap();
        let judge = Judge::new(&study, Some(fmu)).map_err(|error| error.to_string())?;
        let t = &judge.criteria[0];
        let expanded = t.uncertainty.unwrap().expanded;
        assert!((expanded / t.tolerance - 0.5).abs() < 1e-12);
        assert!((judge.variants[0].tolerances[0] / t.tolerance - 2.0).abs() < 1e-12);
        let is_elsewhere = nominal.contains("degC") && unit.is_empty() || unit.contains("mK");
        let words = if is_elsewhere {
            format!("1 % of {}", nominal.trim_matches('"'))
        } else {
            "1 %".to_owned()
        };
        assert_eq!(t.stated_tolerance, words);
        Ok::<_, String>((t.nominal, t.tolerance))
    };
    for (nominal, unit, expected) in [
        ("82", "unit = \"degC\"", (82.0, 0.82)),
        ("\"82 degC\"", "unit = \"degC\"", (82.0, 0.82)),
        ("\"82 degC\"", "", (355.15, 0.82)),
        ("355.15", "", (355.15, 3.5515)),
        ("\"355.15 K\"", "unit = \"K\"", (355.15, 3.5515)),
        ("\"355.15 K\"", "unit = \"mK\"", (355_150.0, 3551.5)),
    ] {
        let (value, tolerance) = of(nominal, unit).unwrap();
        assert!(
            (value - expected.0).abs() < 1e-9,
            "{nominal} {unit}: {value}"
        );
        assert!(
            (tolerance - expected.1).abs() < 1e-9,
            "{nominal} {unit}: {tolerance}"
        );
    }
    let refused = of("\"355.15 K\"", "unit = \"degC\"").unwrap_err();
    assert!(
        refused.contains("T: 1 % could be that of 355.15 K or of 82")
            && refused.contains("\"3.551500 K\" or \"0.820000 degC\""),
        "{refused}"
    );
}

#[test]
fn the_limits_belong_to_what_is_accepted() {
    let judge = judge(&STUDY.replace("0.75 %", "0.5 degC")).unwrap();
    let [t, f] = [&judge.criteria[0], &judge.criteria[1]];
    assert!(t.accepts(81.5) && t.accepts(82.5) && f.accepts(697.5) && f.accepts(802.5));
    assert!(!t.accepts(81.49) && !t.accepts(82.51) && !t.accepts(f64::NAN));
    let variant = |t: f64| judge.variant_verdict(&judge.variants[0], Some(&[t, 750.0]));
    assert_eq!(variant(82.75).passed, [true, true]);
    assert_eq!(variant(82.76).passed, [false, true]);
}

#[test]
fn a_percentage_of_a_negative_value_is_positive() {
    let judge = judge(&STUDY.replace("nominal = 82", "nominal = -82")).unwrap();
    assert!((judge.criteria[0].tolerance - 0.615).abs() < 1e-12);
}

#[test]
fn criteria_of_a_group_are_counted_together() {
    let text = STUDY.replace("unit = \"N\"", "unit = \"N\"\ngroup = \"temperature\"");
    let group = |members: &[usize]| vec![("temperature".to_owned(), members.to_vec())];
    assert_eq!(judge(STUDY).unwrap().groups, group(&[0]));
    assert_eq!(judge(&text).unwrap().groups, group(&[0, 1]));
}

#[test]
fn a_failed_point_is_not_verified() {
    let judge = judge(STUDY).unwrap();
    assert_eq!(judge.verdict(None).passed, [false, false]);
    assert_eq!(judge.verdict(Some(&[82.0])).passed, [true, false]);
    let variant = &judge.variants[0];
    assert_eq!(judge.variant_verdict(variant, None).passed, [false, false]);
    assert!(!PointVerdict::default().verified());
}

#[test]
fn an_interval_reaches_as_far_above_the_measured_value_as_below() {
    let judge = judge(&STUDY.replace("0.75 %", "0.5 degC")).unwrap();
    assert_eq!(judge.criteria[0].accepted(), [81.5, 82.5]);
}

/// A point that fails in one case still tells of the others: each case is judged by all of its own values or not at all.
#[test]
fn a_point_is_judged_in_every_case_in_which_it_did_not_fail() {
    let text = r#"
        fmu = "a.fmu"
        [[cases]]
        name = "slow"
        criteria.T = { variable = "t", nominal = 70, tolerance = 1 }
        criteria.F = { variable = "f", nominal = 5, tolerance = 1 }
        [[cases]]
        name = "fast"
        held-out = true
        criteria.T = { variable = "t", nominal = 80, tolerance = 1 }
    "#;
    let judge = judge(text).unwrap();
    let cases = judge.cases.iter();
    let cases: Vec<_> = cases
        .map(|case| (case.name.as_str(), case.held_out, case.members.clone()))
        .collect();
    assert_eq!(cases, [("slow", false, 0..2), ("fast", true, 2..3)]);

    let failed = |case: &str, values: [Option<f64>; 3]| {
        let failure = Failure::InCase(Box::new(OfCase {
            case: case.to_owned(),
            failure: Failure::Timeout,
            values: values.to_vec(),
        }));
        judge.judged(Err(&failure)).passed
    };
    let (t, f) = (Some(70.5), Some(7.0));
    assert_eq!(failed("fast", [t, f, None]), [true, false, false]);
    assert_eq!(failed("slow", [t, None, Some(80.5)]), [false, false, true]);
    assert_eq!(judge.judged(Err(&Failure::Timeout)).passed, [false; 3]);
    assert_eq!(
        judge.judged(Ok(&[70.5, 7.0, 80.5])).passed,
        [true, false, true]
    );
}

#[test]
fn a_distance_adds_the_squares_of_the_deviations() {
    let judge = judge(STUDY).unwrap();
    let distance = judge.distance(&[82.615, 645.0]);
    assert!((distance - 5_f64.sqrt()).abs() < 1e-9, "{distance}");
}

#[test]
fn columns_can_be_told_apart() {
    for name in [
        "point", "verified", "accepted", "status", "T.ok", "a.width", "", "a\\nb",
    ] {
        let text = STUDY
            .replace("[criteria.F]", &format!("[criteria.\"{name}\"]"))
            .replace(
                "[criteria.T]",
                "[parameters.\"a.width\"]\ndistribution = \"fixed\"\nvalue = 1\n[criteria.T]",
            );
        let error = judge(&text).unwrap_err();
        assert!(error.contains("name"), "{name}: {error}");
    }
}

#[test]
fn a_distance_is_a_number() {
    let judge = judge(&STUDY.replace("0.75 %", "1e-320 degC")).unwrap();
    assert!(judge.distance(&[80.0, 750.0]).is_finite());
}

#[test]
fn errors_have_their_place() {
    assert!(judge("fmu = \"a\"").unwrap_err().contains("no criteria"));
    let wrong = STUDY.replace("\"0.75 %\"", "\"-1 degC\"");
    assert_eq!(
        judge(&wrong).unwrap_err(),
        "s.toml:3:15: T: the tolerance -1 degC must be a positive, finite number"
    );
    for tolerance in ["1e308 %", "0 %", "0 N", "-7 %"] {
        let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
        assert!(
            error.contains("F: the tolerance") && error.ends_with("positive, finite number"),
            "{error}"
        );
    }
    for tolerance in ["0 %", "-7 %"] {
        let nothing = STUDY.replace("750 N", "0 N").replace("7 %", tolerance);
        assert!(judge(&nothing).unwrap_err().contains("must be a positive"));
    }
    for tolerance in ["+0.5/-1", "+0.5 -1", "-1 .. 0.5"] {
        let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
        assert!(error.contains("is the same to both sides"), "{error}");
    }
    let wrong = STUDY.replace("nominal = 82", "nominal = nan");
    assert_eq!(
        judge(&wrong).unwrap_err(),
        "s.toml:3:15: T: the nominal value NaN is not a finite number"
    );
    let wrong = STUDY.replace("nominal = 82", "nominal = 0");
    assert!(judge(&wrong).unwrap_err().contains("give it without %"));
    let wrong = STUDY.replace("tolerance.T =", "tolerance.TT =");
    assert!(judge(&wrong).unwrap_err().contains("no criterion `TT`"));
    let wrong = STUDY.replace("\"0.75 degC\"", "\"0.75 K\"");
    assert!(judge(&wrong).unwrap_err().contains("without the FMU"));
}
