use plain_bearing_stand::oil::measured::read;
use std::io::Write;

fn file(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn rows_are_read_with_comments() {
    let file =
        file("# measured\ntemperature_degC,density_kg_m3,kinematic_viscosity_mm2_s\n40, 863, 105\n100,826,14.2\n");
    let rows = read(file.path()).unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1].kinematic_viscosity, 14.2);
}

#[test]
fn errors_name_the_file_and_the_line() {
    for (text, expected) in [
        ("temperature_degC,density_kg_m3\n40,863\n", "kinematic_viscosity_mm2_s"),
        ("temperature_degC,density_kg_m3,kinematic_viscosity_mm2_s\n40,863,x\n", "line: 2"),
        ("temperature_degC,density_kg_m3,kinematic_viscosity_mm2_s\n40,863,NaN\n", "out of range"),
        ("temperature_degC,density_kg_m3,kinematic_viscosity_mm2_s\n40,863,105\n", "two rows"),
        ("", "two rows"),
    ] {
        let message = read(file(text).path()).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("oil.propertiesFile"), "{message}");
    }
}
