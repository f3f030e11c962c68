//! The sensitivity methods by their names.

use crate::method::FromRuns;
use crate::{RUNS, VIEWS};

/// The methods for any points in words: `rank correlations and PAWN`.
pub fn views() -> String {
    let names: Vec<&str> = VIEWS.iter().map(|view| view.name()).collect();
    names.join(" and ")
}

/// The method of this name.
///
/// # Errors
/// Lists the names that there are.
pub fn named(name: &str) -> Result<&'static dyn FromRuns, String> {
    let known = RUNS.iter().find(|method| method.facts().name == name);
    known.copied().ok_or_else(|| {
        let names: Vec<&str> = RUNS.iter().map(|method| method.facts().name).collect();
        format!("unknown method `{name}`; there are {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::{FirstOrder, Space};
    use crate::testing::settled;

    /// The texts that people read and write: names in a study and on the command line, sizes, and how a study is told.
    #[test]
    fn methods_are_called_by_name_and_say_what_they_do() {
        let space = Space {
            parameters: 4,
            correlation: None,
        };
        let words = |name: &str| {
            let method = named(name).unwrap();
            let runs = method.runs(&space, 7);
            let done = method.done(runs as usize, &settled(7, 1));
            let facts = method.facts();
            assert_eq!(facts.name, name);
            assert_eq!(facts.takes_correlations, name == "shapley");
            (facts.option, facts.usual_size, runs, method.title(7), done)
        };
        let sobol = "Sobol indices from 7 base points";
        let done = format!("{sobol} (42 runs)");
        assert_eq!(words("sobol"), ("base", 256, 42, sobol.to_owned(), done));
        let morris = "Morris screening by 7 trajectories";
        let done = "Morris screening, 35 runs".to_owned();
        assert_eq!(words("morris"), ("morris", 20, 35, morris.to_owned(), done));
        let shapley = "Shapley effects from 7 base points";
        let done = format!("{shapley} (35 runs)");
        assert_eq!(
            words("shapley"),
            ("shapley", 256, 35, shapley.to_owned(), done)
        );
        assert_eq!(views(), "rank correlations and PAWN");
        // Trajectories are no sample of the parameters.
        let sample = named("morris").unwrap().plain_sample(35, &settled(7, 1));
        assert!(sample.is_empty());
        let unknown = named("Sobol").map(|method| method.facts().name);
        let message = "unknown method `Sobol`; there are sobol, morris, shapley";
        assert!(unknown.is_err_and(|error| error.starts_with(message)));
    }

    #[test]
    fn estimators_are_called_by_name() {
        let names = ["combined", "jansen", "saltelli"];
        assert_eq!(FirstOrder::ALL.map(FirstOrder::name), names);
        assert_eq!(names.map(FirstOrder::named), FirstOrder::ALL.map(Some));
        assert_eq!(FirstOrder::named("Jansen"), None);
    }
}
