//! Measured oils: a csv file of viscosity and density over temperature, to which the stand's laws are fitted.

use fmu_export::model::Fault;
use serde::Deserialize;
use std::path::Path;

/// One row of the file. Its columns are `temperature_degC`, `kinematic_viscosity_mm2_s` and
/// `density_kg_m3`, in any order; lines that begin with `#` are comments.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Temperature, °C.
    #[serde(rename = "temperature_degC")]
    pub temperature: f64,
    /// Kinematic viscosity, mm²/s.
    #[serde(rename = "kinematic_viscosity_mm2_s")]
    pub kinematic_viscosity: f64,
    /// Density, kg/m³.
    #[serde(rename = "density_kg_m3")]
    pub density: f64,
}

const COLUMNS: &str = "temperature_degC, kinematic_viscosity_mm2_s, density_kg_m3";

/// Reads the rows of a properties file.
pub fn read(path: &Path) -> Result<Vec<Row>, Fault> {
    let name = path.display();
    let invalid = |what: String| Fault::Invalid(format!("oil.propertiesFile {name}: {what}"));
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| invalid(error.to_string()))?;
    let mut rows = Vec::new();
    for row in reader.deserialize() {
        let row: Row = row.map_err(|error| invalid(format!("{error} (the columns are {COLUMNS})")))?;
        let plausible = (-100.0..400.0).contains(&row.temperature)
            && (1.0..1e7).contains(&row.kinematic_viscosity)
            && (100.0..5000.0).contains(&row.density);
        if !plausible {
            return Err(invalid(format!("row {} is out of range: {row:?}", rows.len() + 1)));
        }
        rows.push(row);
    }
    let distinct = rows.iter().any(|row: &Row| (row.temperature - rows[0].temperature).abs() > 1.0);
    if !distinct {
        return Err(invalid("at least two rows at different temperatures are needed".into()));
    }
    Ok(rows)
}

/// Straight line `a + b*x` through points by least squares.
pub fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let n = points.clone().count() as f64;
    let (sx, sy) = points.clone().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
    let (mx, my) = (sx / n, sy / n);
    let (sxx, sxy) =
        points.fold((0.0, 0.0), |(sxx, sxy), (x, y)| (sxx + (x - mx) * (x - mx), sxy + (x - mx) * (y - my)));
    let slope = sxy / sxx;
    (my - slope * mx, slope)
}
