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
"#;

fn judge(text: &str) -> Result<Judge, String> {
    let study = Study::parse(Path::new("s.toml"), text.to_owned());
    let study = study.map_err(|error| error.to_string())?;
    Judge::new(&study, None).map_err(|error| error.to_string())
}

fn describe(xml: &str) -> Description {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("modelDescription.xml"), xml).unwrap();
    let package = fmu_import::Package::open(folder.path()).unwrap();
    package.description().clone()
}

#[test]
fn percents_are_of_the_nominal_value_as_printed() {
    let judge = judge(STUDY).unwrap();
    assert!((judge.criteria[0].limits.plus - 0.615).abs() < 1e-12);
    assert!((judge.criteria[1].limits.plus - 52.5).abs() < 1e-12);
    assert!(judge.verdict(Some(&[81.39, 697.5])).verified());
    assert!(!judge.verdict(Some(&[81.33, 700.0])).verified());
}

/// A part of a value in a unit with another zero depends on the unit in which the value is written.
#[test]
fn percents_count_in_the_unit_in_which_the_value_is_written() {
    let fmu = r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
        <UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/>
        <DisplayUnit name="mK" factor="1000"/></Unit></UnitDefinitions>
        <ModelVariables><ScalarVariable name="t" valueReference="0" causality="output"><Real unit="K"/>
        </ScalarVariable></ModelVariables><ModelStructure/></fmiModelDescription>"#;
    let fmu = &describe(fmu);
    let of = |nominal: &str, unit: &str| {
        let text = format!(
            "fmu = \"a\"\n[criteria.T]\nvariable = \"t\"\nnominal = {nominal}\ntolerance = \"1 %\"\n\
             uncertainty = \"0.5 %\"\n{unit}\n"
        );
        let study = Study::parse(Path::new("s.toml"), text).unwrap();
        let judge = Judge::new(&study, Some(fmu)).map_err(|error| error.to_string())?;
        let t = &judge.criteria[0];
        let expanded = t.uncertainty.unwrap().expanded;
        assert!((expanded / t.limits.plus - 0.5).abs() < 1e-12);
        let is_elsewhere = nominal.contains("degC") && unit.is_empty() || unit.contains("mK");
        let words = if is_elsewhere { format!("1 % of {}", nominal.trim_matches('"')) } else { "1 %".to_owned() };
        assert_eq!(t.stated_tolerance, words);
        Ok::<_, String>((t.limits.about, t.limits.plus))
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
        assert!((value - expected.0).abs() < 1e-9, "{nominal} {unit}: {value}");
        assert!((tolerance - expected.1).abs() < 1e-9, "{nominal} {unit}: {tolerance}");
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
}

#[test]
fn a_percentage_of_a_negative_value_is_positive() {
    let judge = judge(&STUDY.replace("nominal = 82", "nominal = -82")).unwrap();
    assert!((judge.criteria[0].limits.plus - 0.615).abs() < 1e-12);
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
    let cases: Vec<_> = cases.map(|case| (case.name.as_str(), case.held_out, case.members.clone())).collect();
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
    assert_eq!(judge.judged(Ok(&[70.5, 7.0, 80.5])).passed, [true, false, true]);
}

#[test]
fn a_distance_adds_the_squares_of_the_deviations() {
    let judge = judge(STUDY).unwrap();
    let distance = judge.distance(&[82.615, 645.0]);
    assert!((distance - 5_f64.sqrt()).abs() < 1e-9, "{distance}");
}

#[test]
fn columns_can_be_told_apart() {
    for name in ["point", "verified", "accepted", "conformance", "status", "T.ok", "a.width", "", "a\\nb"] {
        let text = STUDY
            .replace("[criteria.F]", &format!("[criteria.\"{name}\"]"))
            .replace("[criteria.T]", "[parameters.\"a.width\"]\ndistribution = \"fixed\"\nvalue = 1\n[criteria.T]");
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
    assert_eq!(judge(&wrong).unwrap_err(), "s.toml:3:15: T: the tolerance -1 degC must be a positive, finite number");
    for tolerance in ["1e308 %", "0 %", "0 N", "-7 %"] {
        let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
        assert!(error.contains("F: the tolerance") && error.ends_with("positive, finite number"), "{error}");
    }
    for tolerance in ["0 %", "-7 %"] {
        let nothing = STUDY.replace("750 N", "0 N").replace("7 %", tolerance);
        assert!(judge(&nothing).unwrap_err().contains("must be a positive"));
    }
    for tolerance in ["+0.5/-1", "+0.5 -1", "-1 .. 0.5"] {
        let error = judge(&STUDY.replace("7 %", tolerance)).unwrap_err();
        assert!(error.contains("a single limit is `at-most`"), "{error}");
    }
    let wrong = STUDY.replace("nominal = 82", "nominal = nan");
    assert_eq!(judge(&wrong).unwrap_err(), "s.toml:3:15: T: the nominal value NaN is not a finite number");
    let wrong = STUDY.replace("nominal = 82", "nominal = 0");
    assert!(judge(&wrong).unwrap_err().contains("give it without %"));
}

const ALONE: &str = r#"
    fmu = "a.fmu"
    [criteria.T]
    variable = "t"
    at-most = "85 degC"
    measured = 82
    uncertainty = "0.5 degC"
    unit = "degC"
    [criteria.F]
    variable = "f"
    at-least = 700
    unit = "N"
    [criteria.M]
    variable = "m"
    nominal = 3
    tolerance = { minus = "1 %", plus = "0.5 N.m" }
    unit = "N.m"
"#;

#[test]
fn a_limit_may_stand_alone_and_a_tolerance_be_uneven() {
    let judge = judge(ALONE).unwrap();
    let [t, f, m] = &judge.criteria[..] else { panic!("three criteria") };
    let passed = |values: [f64; 3]| judge.verdict(Some(&values)).passed;
    assert_eq!(passed([85.0, 700.0, 2.97]), [true; 3]);
    assert_eq!(passed([85.01, 699.9, 2.969]), [false; 3]);
    assert_eq!(passed([-1e9, 1e9, 3.5]), [true; 3]);
    assert_eq!(passed([f64::NAN, f64::NAN, 3.51]), [false; 3]);
    assert_eq!([t, f, m].map(Criterion::wanted), ["at most 85 degC", "at least 700 N", "3 N.m -1 %/+0.5 N.m"]);
    assert_eq!([t, f, m].map(|c| c.measured().value), [Some(82.0), None, Some(3.0)]);
    // Units of the distance: the expanded uncertainty, the limit itself.
    assert_eq!((t.room(), f.room()), (0.5, 700.0));
    for (criterion, value, deviation) in [
        (t, 85.0, 1.0),
        (t, 84.75, 0.5),
        (t, 80.0, 0.0),
        (t, 86.0, 3.0),
        (f, 700.0, 1.0),
        (f, 0.0, 2.0),
        (f, 1e6, 0.0),
        (m, 3.25, 0.5),
        (m, 2.97, 1.0),
        (m, 3.0, 0.0),
    ] {
        let found = criterion.deviation(value);
        assert!((found - deviation).abs() < 1e-9, "{} {value}: {found}", criterion.name);
    }
    assert!(t.deviation(f64::NAN).is_nan());
    // A summary gives them back.
    for criterion in &judge.criteria {
        let text = serde_json::to_string(criterion).unwrap();
        let again: Criterion = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (again.limits, again.reading, again.distance_unit),
            (criterion.limits, criterion.reading, criterion.distance_unit)
        );
    }
}

#[test]
fn limits_that_do_not_fit_are_refused_with_the_remedy() {
    for (from, to, remedy) in [
        ("at-most = \"85 degC\"", "at-most = \"85 degC\"\nnominal = 82", "a limit takes the place of `nominal`"),
        ("at-most = \"85 degC\"", "at-most = \"85 degC\"\ntolerance = 1", "a limit takes the place of `tolerance`"),
        ("at-most = \"85 degC\"", "at-most = \"85 degC\"\nat-least = 80", "nominal = (a + b) / 2"),
        ("nominal = 3", "nominal = 3\nmeasured = 3", "`measured` stands beside"),
        ("at-least = 700", "at-least = nan", "is not a finite number"),
        ("minus = \"1 %\"", "minus = 0", "must be a positive, finite number"),
        ("minus = \"1 %\", ", "", "{ minus = \"1 mm\", plus = \"2 mm\" }"),
        ("at-least = 700", "above = 700", "a single limit is `at-most` or `at-least`"),
    ] {
        assert!(ALONE.contains(from), "{from}");
        let error = judge(&ALONE.replacen(from, to, 1)).unwrap_err();
        assert!(error.starts_with("s.toml:") && error.contains(remedy), "{to}: {error}");
    }
}

const PRODUCT: &str = r#"
    fmu = "a.fmu"
    [fixed]
    speed = 40
    [criteria.M]
    variable = "m"
    nominal = 0.5
    tolerance = "5 %"
    uncertainty = "2 %"
    [criteria.n]
    variable = "n"
    nominal = 40
    tolerance = 1
    uncertainty = "1.5 %"
    [criteria.F]
    variable = "f"
    nominal = 7
    tolerance = 1
    uncertainty = 1
    [criteria.P]
    variable = "p"
    nominal = 20
    tolerance = "5 %"
    derived = { from = "M", by = "n" }
    [[uncertainty-correlations]]
    between = ["M", "F"]
    coefficient = 0.5
"#;

/// 0.5 N.m at 382 rpm are 20 W; a force is no power, and a power of 20 kW another one.
#[test]
fn a_product_has_the_unit_and_the_value_of_its_factors() {
    let units = [
        ("N.m", r#"kg="1" m="2" s="-2""#, ""),
        ("W", r#"kg="1" m="2" s="-3""#, r#"<DisplayUnit name="kW" factor="0.001"/>"#),
        ("N", r#"kg="1" m="1" s="-2""#, ""),
        ("rad/s", r#"rad="1" s="-1""#, r#"<DisplayUnit name="rpm" factor="9.549296585513721"/>"#),
    ];
    let units = units.map(|(name, base, shown)| format!(r#"<Unit name="{name}"><BaseUnit {base}/>{shown}</Unit>"#));
    let variables = [("m", "N.m"), ("p", "W"), ("f", "N"), ("n", "rad/s")].map(|(name, unit)| {
        let kind = match name {
            "n" => r#"causality="input"><Real start="1""#,
            _ => r#"causality="output"><Real"#,
        };
        format!(r#"<ScalarVariable name="{name}" valueReference="0" {kind} unit="{unit}"/></ScalarVariable>"#)
    });
    let fmu = format!(
        r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
        <UnitDefinitions>{}</UnitDefinitions><ModelVariables>{}</ModelVariables><ModelStructure/></fmiModelDescription>"#,
        units.concat(),
        variables.concat()
    );
    let fmu = describe(&fmu);
    let with = |power: &str| {
        let text = format!(
            "fmu = \"a.fmu\"\n[fixed]\nn = \"382 rpm\"\n[criteria.M]\nvariable = \"m\"\nnominal = 0.5\ntolerance = 1\n\
             uncertainty = 0.01\n[criteria.P]\n{power}\ntolerance = \"5 %\"\nderived = {{ from = \"M\", by = \"n\" }}\n"
        );
        let study = Study::parse(Path::new("s.toml"), text).unwrap();
        Judge::new(&study, Some(&fmu)).map_err(|error| error.to_string())
    };
    assert!(with("variable = \"p\"\nnominal = \"20 W\"").is_ok());
    assert!(with("variable = \"p\"\nunit = \"kW\"\nnominal = 0.02").is_ok());
    for (power, remedy) in [
        ("variable = \"p\"\nunit = \"kW\"\nnominal = 20", "is 999.9263 times"),
        ("variable = \"f\"\nnominal = 20", "its unit is not that of M x n"),
    ] {
        let error = with(power).unwrap_err();
        assert!(error.contains(remedy), "{error}");
    }
}

/// Relative uncertainties of 2 and 1.5 % make one of 2.5 %; the shares of the errors are 0.8 and 0.6.
#[test]
fn the_error_of_a_product_follows_from_its_factors() {
    let error = |judge: &Judge, k: usize| judge.criteria[k].measured().error.unwrap();
    let both = judge(PRODUCT).unwrap();
    assert!((error(&both, 3).expanded - 0.5).abs() < 1e-12);
    let correlation = |judge: &Judge, a: usize, b: usize| {
        let mut pairs = judge.measurement.correlations().iter();
        let pair = pairs.find(|&&(x, y, _)| (x, y) == (a, b) || (y, x) == (a, b));
        pair.map_or(0.0, |pair| pair.2)
    };
    for (factor, expected) in [(0, 0.8), (1, 0.6), (2, 0.4)] {
        assert!((correlation(&both, 3, factor) - expected).abs() < 1e-12, "{factor}");
    }
    // By an input the error is the torque's, and no second measurement.
    let one = judge(&PRODUCT.replace("by = \"n\"", "by = \"speed\"")).unwrap();
    assert!((error(&one, 3).expanded - 0.4).abs() < 1e-12);
    assert_eq!(correlation(&one, 3, 0), 1.0);
    for (from, to, remedy) in [
        ("between = [\"M\", \"F\"]", "between = [\"M\", \"P\"]", "follows from `derived`"),
        ("by = \"n\"", "by = \"speeed\"", "is no criterion, and no input"),
        ("from = \"M\"", "from = \"MM\"", "there is no criterion `MM`"),
        ("derived", "uncertainty = 1\nderived", "remove `uncertainty`"),
        ("uncertainty = \"2 %\"", "", "its `uncertainty`"),
        ("nominal = 20", "nominal = 25", "1.2500 times the product of M and n"),
        (
            "nominal = 20\n    tolerance = \"5 %\"\n    derived = { from = \"M\", by = \"n\" }",
            "nominal = 15\n    tolerance = \"5 %\"\n    derived = { from = \"M\", by = \"speed\" }",
            "0.7500 times the product of M and speed",
        ),
    ] {
        let error = judge(&PRODUCT.replacen(from, to, 1)).unwrap_err();
        assert!(error.starts_with("s.toml:") && error.contains(remedy), "{to}: {error}");
    }
}
