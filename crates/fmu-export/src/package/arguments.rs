//! The command line of the packer.

use std::path::PathBuf;

use super::{Binary, Form, PackageError, build::platform};
use crate::description::{Interface, Version};

/// The options, in words.
pub const HELP: &str = "\
Builds the model's library and packs it into an FMU.

Options:
  --fmi VERSION            the version of the standard, 2 or 3 (by default 2)
  --exchange               Model Exchange instead of Co-Simulation
  --output FILE            the FMU (by default IDENTIFIER.fmu, with -me and -fmi3 as it may be, beside the library)
  --profile PROFILE        cargo's profile (by default release)
  --target TRIPLE          build for this platform instead of this machine's; may be repeated
  --add PLATFORM=LIBRARY   take a library that was built elsewhere, such as win64=model.dll; may be repeated

Example: cargo run -- --output dist/Tank.fmu";

/// The packer's command line.
#[derive(Debug, PartialEq)]
pub struct Arguments {
    pub output: Option<PathBuf>,
    pub profile: String,
    pub form: Form,
    targets: Vec<String>,
    added: Vec<(String, PathBuf)>,
}

impl Arguments {
    /// The platforms to build for; `None` is this machine's.
    pub fn targets(&self) -> Vec<Option<&str>> {
        if self.targets.is_empty() {
            return vec![None];
        }
        self.targets.iter().map(|target| Some(target.as_str())).collect()
    }

    /// The libraries that were built elsewhere.
    pub fn added(&self) -> Result<Vec<Binary>, PackageError> {
        self.added
            .iter()
            .map(|(name, library)| {
                let platform = platform::named(name, self.form).ok_or_else(|| {
                    let names = platform::names().join(", ");
                    PackageError::Usage(format!("--add {name}=...: the platforms are {names}"))
                })?;
                let library = library.clone();
                Ok(Binary { platform, library })
            })
            .collect()
    }
}

/// The arguments; `None` when help is asked for.
pub fn parse(mut given: impl Iterator<Item = String>) -> Result<Option<Arguments>, PackageError> {
    let mut arguments = Arguments {
        output: None,
        profile: "release".to_owned(),
        form: Form::default(),
        targets: Vec::new(),
        added: Vec::new(),
    };
    while let Some(option) = given.next() {
        if option == "--help" || option == "-h" {
            return Ok(None);
        }
        if option == "--exchange" {
            arguments.form.interface = Interface::ModelExchange;
            continue;
        }
        let known = ["--fmi", "--output", "--profile", "--target", "--add"].contains(&option.as_str());
        if !known {
            return Err(PackageError::Usage(format!("there is no option {option}")));
        }
        let value = given.next().ok_or_else(|| PackageError::Usage(format!("{option} needs a value")))?;
        match option.as_str() {
            "--fmi" => arguments.form.version = version(&value)?,
            "--output" => arguments.output = Some(value.into()),
            "--profile" => arguments.profile = value,
            "--target" => arguments.targets.push(value),
            _ => arguments.added.push(added(&value)?),
        }
    }
    arguments.added()?;
    Ok(Some(arguments))
}

fn version(value: &str) -> Result<Version, PackageError> {
    match value {
        "2" | "2.0" => Ok(Version::Two),
        "3" | "3.0" => Ok(Version::Three),
        _ => Err(PackageError::Usage(format!("--fmi {value}: the versions are 2 and 3"))),
    }
}

fn added(value: &str) -> Result<(String, PathBuf), PackageError> {
    let (name, library) =
        value.split_once('=').ok_or_else(|| PackageError::Usage(format!("--add {value}: write PLATFORM=LIBRARY")))?;
    Ok((name.to_owned(), library.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Option<Arguments>, PackageError> {
        parse(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn options_are_read() {
        let arguments = parsed("--output a/b.fmu --add win64=c.dll --profile dev").unwrap().unwrap();
        assert_eq!(arguments.output, Some("a/b.fmu".into()));
        assert_eq!(arguments.added, [("win64".to_owned(), "c.dll".into())]);
        assert_eq!((arguments.profile.as_str(), arguments.targets()), ("dev", vec![None]));
        assert_eq!(parsed("--profile dev --help").unwrap(), None);
        let exchange = parsed("--exchange --fmi 3").unwrap().unwrap();
        assert_eq!(exchange.form.suffix(), "-me-fmi3");
        let three = parsed("--add win64=c.dll --fmi 3").unwrap().unwrap();
        assert_eq!(three.added().unwrap()[0].platform, "x86_64-windows");
        let two = parsed("--target a --target b").unwrap().unwrap();
        assert_eq!(two.targets(), [Some("a"), Some("b")]);
    }

    #[test]
    fn mistakes_are_told_with_the_options() {
        for (line, says) in [
            ("--jobs 3", "there is no option --jobs"),
            ("--output", "--output needs a value"),
            ("--add c.dll", "write PLATFORM=LIBRARY"),
            ("--add mac=c.dylib", "the platforms are linux64"),
            ("--fmi 1", "the versions are 2 and 3"),
        ] {
            let message = parsed(line).unwrap_err().to_string();
            assert!(message.contains(says) && message.contains("--profile PROFILE"), "{message}");
        }
    }
}
