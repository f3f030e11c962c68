//! `studies/study.schema.json` says what the reader reads: the same keys, the same words.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;

use super::Study;
use curves::Metric;
use sampling::{design::Method, statistics::Statistic};
use sensitivity::RUNS;

fn studies() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies")
}

fn schema() -> Value {
    let text = fs::read_to_string(studies().join("study.schema.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The names that the reader would have taken instead of `unheard-of`, as its error tells them.
fn expected(text: &str) -> BTreeSet<String> {
    let error = toml::from_str::<Study>(text).unwrap_err();
    let mut names = error.message().split('`').skip(1).step_by(2);
    assert_eq!(names.next(), Some("unheard-of"), "{error}");
    names.map(str::to_owned).collect()
}

fn keys(schema: &Value) -> BTreeSet<String> {
    schema["properties"].as_object().unwrap().keys().cloned().collect()
}

#[test]
fn the_schema_has_exactly_the_keys_that_the_reader_takes() {
    let schema = schema();
    assert_eq!(keys(&schema), expected("unheard-of = 1"), "a study");
    let places = [
        ("simulation", "[simulation]\n"),
        ("design", "[design]\n"),
        ("parameter", "[parameters.x]\n"),
        ("correlation", "[[correlations]]\n"),
        ("recording", "[inputs.x]\n"),
        ("criterion", "[criteria.x]\n"),
        ("case", "[[cases]]\n"),
        ("verdict", "[verdict]\n"),
        ("identify", "[identify]\n"),
        ("free", "[identify.free.x]\n"),
        ("known", "[identify.known.x]\n"),
        ("latent", "[identify.latent.x]\n"),
        ("exception", "[[identify.latent.x.except]]\n"),
        ("measured", "[identify.measured.x]\n"),
        ("sensitivity", "[sensitivity]\n"),
        ("robustness", "[robustness]\n"),
        ("tolerances", "[tolerances]\n"),
    ];
    for (name, section) in places {
        let text = format!("fmu = \"a.fmu\"\n{section}unheard-of = 1\n");
        assert_eq!(keys(&schema["$defs"][name]), expected(&text), "{name}");
    }
}

#[test]
fn the_schema_has_exactly_the_words_that_the_reader_takes() {
    let defs = &schema()["$defs"];
    let places = [
        (&defs["design"]["properties"]["method"], "[design]\nmethod"),
        (&defs["parameter"]["properties"]["distribution"], "[parameters.x]\ndistribution"),
        (&defs["statistic"], "[criteria.x]\nstatistic"),
        (&defs["criterion"]["properties"]["metric"], "[criteria.x]\nmetric"),
        (&defs["free"]["properties"]["scale"], "[identify.free.x]\nscale"),
    ];
    for (schema, place) in places {
        let words = schema["enum"].as_array().unwrap().iter();
        let words: BTreeSet<String> = words.map(|word| word.as_str().unwrap().into()).collect();
        let text = format!("fmu = \"a.fmu\"\n{place} = \"unheard-of\"\n");
        assert_eq!(words, expected(&text), "{place}");
    }
}

/// The words that follow from registers, and their places in the schema.
fn registered() -> [(&'static str, Vec<String>); 4] {
    let designs = Method::ALL.iter().map(|method| method.name());
    let statistics = Statistic::ALL.iter().map(|statistic| statistic.name());
    let metrics = Metric::ALL.iter().map(|metric| metric.name());
    let sensitivity = RUNS.iter().map(|method| method.facts().name.to_owned());
    [
        ("/$defs/design/properties/method/enum", designs.collect()),
        ("/$defs/statistic/enum", statistics.collect()),
        ("/$defs/criterion/properties/metric/enum", metrics.collect()),
        ("/$defs/sensitivity/properties/method/enum", sensitivity.collect()),
    ]
}

/// With the environment variable `WRITE_SCHEMA` the test mends the file.
#[test]
fn the_schema_names_what_is_registered() {
    let mut schema = schema();
    for (place, words) in registered() {
        *schema.pointer_mut(place).unwrap() = words.into();
    }
    let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
    let path = studies().join("study.schema.json");
    if std::env::var_os("WRITE_SCHEMA").is_some() {
        fs::write(&path, &text).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap() == text,
        "run `WRITE_SCHEMA=1 cargo test --workspace --lib the_schema_names`"
    );
}

/// Violations of a JSON Schema, for the part of JSON Schema that the study's schema uses.
fn faults(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    if *schema == Value::Bool(false) {
        return vec![format!("{at} has no place here")];
    }
    let mut wrong = Vec::new();
    if let Some(name) = schema["$ref"].as_str() {
        let target = root.pointer(name.trim_start_matches('#')).unwrap();
        wrong.extend(faults(root, target, value, at));
    }
    let is = |kind: &str| match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        other => panic!("the schema has the type {other}"),
    };
    let typed = match &schema["type"] {
        Value::String(kind) => is(kind),
        Value::Array(kinds) => kinds.iter().any(|kind| is(kind.as_str().unwrap())),
        _ => true,
    };
    if !typed {
        wrong.push(format!("{at} is no {}", schema["type"]));
    }
    let words = schema["enum"].as_array();
    if words.is_some_and(|words| !words.contains(value)) || schema.get("const").is_some_and(|word| word != value) {
        wrong.push(format!("{at} is {value}"));
    }
    for bound in ["minimum", "exclusiveMinimum"] {
        if let (Some(min), Some(number)) = (schema[bound].as_f64(), value.as_f64())
            && (number < min || bound != "minimum" && number == min)
        {
            wrong.push(format!("{at} is {number}"));
        }
    }
    for part in schema["allOf"].as_array().into_iter().flatten() {
        if faults(root, &part["if"], value, at).is_empty() {
            wrong.extend(faults(root, &part["then"], value, at));
        }
    }
    for item in value.as_array().into_iter().flatten() {
        wrong.extend(faults(root, &schema["items"], item, at));
    }
    let Some(table) = value.as_object() else {
        return wrong;
    };
    for name in schema["required"].as_array().into_iter().flatten() {
        if !table.contains_key(name.as_str().unwrap()) {
            wrong.push(format!("{at} lacks {name}"));
        }
    }
    for (key, value) in table {
        let property = schema["properties"].get(key);
        if let Some(schema) = property.or(schema.get("additionalProperties")) {
            wrong.extend(faults(root, schema, value, &format!("{at}.{key}")));
        }
    }
    wrong
}

fn faults_of(text: &str) -> Vec<String> {
    let value: Value = toml::from_str(text).unwrap();
    let schema = schema();
    faults(&schema, &schema, &value, "study")
}

#[test]
fn every_shipped_study_is_valid() {
    let mut count = 0;
    for entry in fs::read_dir(studies()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let text = fs::read_to_string(&path).unwrap();
            assert_eq!(faults_of(&text), [""; 0], "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 5, "{count} studies");
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    let mistakes = [
        ("fmu = 3", "study.fmu is no"),
        ("fmu = \"a\"\n[design]\npionts = 3", "study.design.pionts"),
        ("fmu = \"a\"\n[design]\nmethod = \"sobel\"", "study.design.method"),
        ("fmu = \"a\"\n[parameters.x]\ndistribution = \"normal\"\nmean = 1", "study.parameters.x lacks \"deviation\""),
        ("fmu = \"a\"\n[parameters.x]\ndistribution = \"fixed\"\nvalue = 1\nmax = 2", "study.parameters.x.max"),
        ("fmu = \"a\"\n[criteria.x]\nvariable = \"y\"\nnominal = 1", "study.criteria.x lacks \"tolerance\""),
        ("fmu = \"a\"\n[criteria.x]\nvariable = \"y\"\nat-most = 1\nnominal = 1", "study.criteria.x.nominal"),
        (
            "fmu = \"a\"\n[criteria.x]\nvariable = \"y\"\nnominal = 1\ntolerance = { minus = 1 }",
            "study.criteria.x.tolerance lacks \"plus\"",
        ),
        (
            "fmu = \"a\"\n[criteria.x]\nvariable = \"y\"\nreference = { file = \"m.csv\" }\nmetric = \"rmse\"\nnominal = 1",
            "study.criteria.x.nominal",
        ),
        ("fmu = \"a\"\n[criteria.x]\nvariable = \"y\"\nnominal = 1\ntolerance = 1\nband = 1", "study.criteria.x.band"),
    ];
    for (text, words) in mistakes {
        let faults = faults_of(text);
        assert!(faults.iter().any(|fault| fault.starts_with(words)), "{text}: {faults:?}");
    }
}
