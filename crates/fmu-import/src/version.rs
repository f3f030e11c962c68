//! The versions of the standard that are read and run.

/// A version of FMI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    #[default]
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// The version that `fmiVersion` states; 2.0.x and 3.0.x count as 2.0 and 3.0.
    pub fn of(text: &str) -> Option<Self> {
        match text.split('.').next() {
            Some("2") => Some(Self::Two),
            Some("3") => Some(Self::Three),
            _ => None,
        }
    }

    /// Its number.
    pub fn number(self) -> &'static str {
        match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        }
    }

    /// The prefix of its functions' names.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Two => "fmi2",
            Self::Three => "fmi3",
        }
    }

    /// The name of the folder with this machine's binaries. FMI 2.0 names none for 64-bit ARM; tools use the name of
    /// FMI 3.0.
    pub const fn platform(self) -> &'static str {
        let [two, three] = PLATFORMS;
        match self {
            Self::Two => two,
            Self::Three => three,
        }
    }
}

/// This machine's folders in FMI 2.0 and 3.0.
const PLATFORMS: [&str; 2] = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    ["linux64", "x86_64-linux"]
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    ["win64", "x86_64-windows"]
} else if cfg!(all(target_os = "macos", target_arch = "x86_64")) {
    ["darwin64", "x86_64-darwin"]
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    ["aarch64-linux", "aarch64-linux"]
} else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
    ["aarch64-darwin", "aarch64-darwin"]
} else {
    ["unknown", "unknown"]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_told_by_their_first_number() {
        let versions = ["2", "2.0", "2.0.4", "3.0", "3.0-beta.2", "1.0", "20", ""].map(Version::of);
        let (two, three) = (Some(Version::Two), Some(Version::Three));
        assert_eq!(versions, [two, two, two, three, three, None, None, None]);
    }
}
