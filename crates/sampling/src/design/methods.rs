//! What follows from the list of designs in `design/mod.rs`: the choice, its names and its checks.

use super::Method;

/// Makes the choice of the designs from lines of name, type and meaning.
macro_rules! methods {
    ($($method:ident = $rule:ty, $meaning:literal;)*) => {
        /// How points are chosen.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Method {
            $(#[doc = $meaning] $method,)*
        }

        impl Method {
            /// All of them; the first one is the usual one.
            pub const ALL: &[Self] = &[$(Self::$method),*];

            /// Whether the first points stay the same when there are more: then fewer may be enough.
            pub fn is_extensible(self) -> bool {
                match self {
                    $(Self::$method => <$rule as rule::Registered>::EXTENSIBLE,)*
                }
            }

            /// Whether any count of so many points scatters no more than that of independent ones, so that their intervals hold.
            /// Nothing is proven of a Latin hypercube whose inputs are mixed to correlate.
            pub fn is_independent(self, points: u64, correlated: bool) -> bool {
                let from = match self {
                    $(Self::$method => <$rule as rule::Registered>::INDEPENDENT_FROM,)*
                };
                points >= from && !(correlated && self == Self::LatinHypercube)
            }

            /// Whether the points can belong in turn to independent randomisations.
            pub fn has_replicates(self) -> bool {
                match self {
                    $(Self::$method => <$rule as rule::Registered>::REPLICATES,)*
                }
            }

            /// The rule for the points of a study.
            fn rule(self, sampling: &Sampling, inputs: &Inputs) -> Result<Arc<dyn Rule>, String> {
                Ok(match self {
                    $(Self::$method => Arc::new(<$rule as rule::Registered>::new(sampling, inputs)?),)*
                })
            }
        }
    };
}

impl Method {
    /// Its name in a study.
    pub fn name(self) -> String {
        crate::word(&self)
    }

    /// The names of those that have a property, for a sentence: `a, b or c`.
    pub fn named(has: impl Fn(Self) -> bool) -> String {
        let names: Vec<String> = Self::ALL.iter().filter(|method| has(**method)).map(|method| method.name()).collect();
        match names.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, others)) => format!("{} or {last}", others.join(", ")),
            None => String::new(),
        }
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::ALL[0]
    }
}
