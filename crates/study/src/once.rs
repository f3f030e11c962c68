//! Every variable is set in one place: of two values for one variable the FMU would keep the one that it gets last.

use crate::Result;
use std::collections::HashMap;

use super::{Name, Study};
use fmu_import::Description;

impl Study {
    /// The variables that the study sets, each with the section that does.
    pub fn set(&self) -> impl Iterator<Item = (&Name, &'static str)> {
        let parameters = self.parameters.keys().map(|name| (name, "[parameters]"));
        let fixed = self.fixed.keys().map(|name| (name, "[fixed]"));
        let inputs = self.inputs.keys().map(|name| (name, "[inputs]"));
        parameters.chain(fixed).chain(inputs)
    }

    /// Refuses a variable that is set twice, also by another of its names. Unknown names are left to those who need
    /// their variables.
    ///
    /// # Errors
    /// At the second place, with the section of the first.
    pub fn once<'a>(&self, fmu: &Description, set: impl Iterator<Item = (&'a Name, &'static str)>) -> Result {
        let mut seen: HashMap<_, (&str, &str)> = HashMap::new();
        for (name, section) in set {
            let key = name.as_ref().as_str();
            let Some(variable) = fmu.variables.get(key) else { continue };
            let Some((first, other)) = seen.insert(variable.handle(), (key, section)) else { continue };
            let message = if first == key {
                format!("{key} is under {other} and {section}; keep one")
            } else {
                format!("{key} is another name of {first}, which is under {other}; keep one")
            };
            return Err(self.error_at(name, message));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_import::{Causality, Kind, Variability, Variable};
    use std::path::Path;

    /// `a` and `b` are names of one variable, `c` and the text `d` stand for others.
    fn fmu() -> Description {
        let variable = |name: &str, value_reference: u32, kind: Kind| Variable {
            name: name.to_owned(),
            line: 1,
            value_reference,
            place: None,
            description: None,
            causality: Causality::Parameter,
            variability: Variability::Fixed,
            clocks: Vec::new(),
            kind,
        };
        let mut fmu = Description::default();
        for (name, reference, kind) in [
            ("a", 1, Kind::Boolean { start: None }),
            ("b", 1, Kind::Boolean { start: None }),
            ("c", 2, Kind::Boolean { start: None }),
            ("d", 1, Kind::String { start: None }),
        ] {
            let variable = variable(name, reference, kind);
            fmu.variables.insert(name.to_owned(), variable);
        }
        fmu
    }

    fn error(text: &str) -> Option<String> {
        let text = format!("fmu = \"s.fmu\"\n{text}");
        let study = Study::parse(Path::new("s.toml"), text).unwrap();
        let outcome = study.once(&fmu(), study.set());
        outcome.err().map(|error| error.to_string())
    }

    #[test]
    fn a_variable_is_set_once_whatever_its_name() {
        let varied = |name: &str| format!("[parameters.{name}]\ndistribution = \"uniform\"\nmin = 0\nmax = 1\n");
        let recorded = |name: &str| format!("[inputs.{name}]\nfile = \"r.csv\"\n");
        let both = format!("{}{}", varied("a"), varied("b"));
        assert_eq!(error(&both).unwrap(), "s.toml:6:13: b is another name of a, which is under [parameters]; keep one");
        let text = format!("{}[fixed]\nc = true\nb = true\n", varied("a"));
        assert_eq!(error(&text).unwrap(), "s.toml:8:1: b is another name of a, which is under [parameters]; keep one");
        let text = format!("{}{}", varied("c"), recorded("c"));
        assert_eq!(error(&text).unwrap(), "s.toml:6:9: c is under [parameters] and [inputs]; keep one");
        let text = format!("{}{}[fixed]\nd = \"x\"\n", varied("b"), recorded("c"));
        assert_eq!(error(&text), None);
    }
}
