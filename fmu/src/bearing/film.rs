//! The film models: the one place that knows them all.
//!
//! A new film model is a file beside [`mobility`] with a type that implements [`JournalFilm`], its `mod` line and its line
//! in `films!` below. The choice `bearing.film` of the FMU and its items follow from that line.

mod mobility;
mod reynolds;

pub use mobility::sommerfeld;

use crate::Result;
use fmu_export::model::{Enumeration, Item};
use journal_bearing::reynolds::Coefficients;
use serde::{Deserialize, Serialize};

use super::{
    journal::{Drift, FilmSetup, JournalFilm, Motion, Press, Situation, Strain, TransientFilm},
    parameters::Bearing,
};

/// Makes the choice of the film models, and the film in use, from lines of name, value, type and meaning.
macro_rules! films {
    ($($model:ident = $value:literal, $film:ty, $meaning:literal;)*) => {
        /// The choice of the film model.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum FilmModel {
            $(#[doc = concat!($meaning, ".")] $model = $value,)*
        }

        /// The film models as the FMU shows them.
        pub const FILM: Enumeration = Enumeration {
            name: "Film",
            description: "Film model of the bearing",
            items: &[$(Item { name: stringify!($model), value: $value, description: $meaning }),*],
        };

        impl FilmModel {
            /// All film models; the first one is the default.
            pub const ALL: &[Self] = &[$(Self::$model),*];

            fn start(self, setup: &FilmSetup) -> Result<Running> {
                match self {
                    $(Self::$model => <$film as JournalFilm>::new(setup).map(Running::$model),)*
                }
            }
        }

        /// The film in use.
        #[derive(Clone, Debug, Default, Serialize, Deserialize)]
        enum Running {
            /// Before the start.
            #[default]
            None,
            $($model($film),)*
        }

        impl Running {
            fn film(&self) -> Option<&dyn JournalFilm> {
                match self {
                    Self::None => None,
                    $(Self::$model(film) => Some(film),)*
                }
            }

            fn film_mut(&mut self) -> Option<&mut dyn JournalFilm> {
                match self {
                    Self::None => None,
                    $(Self::$model(film) => Some(film),)*
                }
            }
        }

        // Each film's code in its place, as the time integration asks for nothing else.
        impl Film {
            /// The velocities and flows that the time integration needs; the side flow where it is asked for.
            #[inline]
            pub fn drift(&self, bearing: &Bearing, at: &Situation, side_flow: bool, press: &mut Press) -> Drift {
                match &self.running {
                    Running::None => Drift::default(),
                    $(Running::$model(film) => film.drift(bearing, at, side_flow, press),)*
                }
            }

            /// How film and asperities press at an instant, of which `press` is known from [`drift`](Self::drift).
            #[inline]
            pub fn strain(&self, bearing: &Bearing, at: &Situation, press: &Press) -> Strain {
                match &self.running {
                    Running::None => Strain::default(),
                    $(Running::$model(film) => film.strain(bearing, at, press),)*
                }
            }
        }
    };
}

films! {
    Mobility = 1, mobility::MobilityFilm, "Mobility method on the map of our own Reynolds solutions";
    Reynolds = 2, reynolds::ReynoldsJournal, "Transient two-dimensional Reynolds equation with mass conservation";
}

/// The film model that was chosen, and from the start on the film in use.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Film {
    /// The choice; it takes effect at the next start.
    pub model: FilmModel,
    running: Running,
}

impl FilmModel {
    /// The value of its item.
    pub fn value(self) -> i32 {
        self as i32
    }

    /// The model of an item's value.
    pub fn of(value: i32) -> Self {
        let mut all = Self::ALL.iter().copied();
        all.find(|model| model.value() == value).expect("hosts can set no other value than those of the items")
    }
}

impl Default for Film {
    fn default() -> Self {
        Self { model: FilmModel::ALL[0], running: Running::None }
    }
}

impl Film {
    /// Starts the chosen film, with the journal in the middle.
    ///
    /// # Errors
    /// When a parameter or a file is not usable.
    pub fn start(&mut self, setup: &FilmSetup) -> Result {
        self.running = self.model.start(setup)?;
        Ok(())
    }

    /// Whether it was started.
    pub fn is_running(&self) -> bool {
        !matches!(self.running, Running::None)
    }

    /// The mobility film of a bearing, for estimates of what another film would take long to say.
    ///
    /// # Errors
    /// When a parameter is not usable.
    pub fn mobility(bearing: &Bearing) -> Result<Self> {
        let mut film = mobility::MobilityFilm::default();
        film.prepare(bearing)?;
        Ok(Self { model: FilmModel::Mobility, running: Running::Mobility(film) })
    }

    /// Computes all that follows from the bearing's parameters alone.
    ///
    /// # Errors
    /// When a parameter is not usable.
    pub fn prepare(&mut self, bearing: &Bearing) -> Result {
        (self.running.film_mut()).map_or(Ok(()), |film| film.prepare(bearing))
    }

    /// The journal's motion at an instant.
    pub fn motion(&self, bearing: &Bearing, at: &Situation) -> Motion {
        let film = self.running.film();
        film.map_or_else(Motion::default, |film| film.motion(bearing, at))
    }

    /// [`drift`](Self::drift) at many instants of one clearance, m.
    pub fn drift_at<'a>(
        &'a self,
        bearing: &'a Bearing,
        clearance: f64,
    ) -> impl Fn(&Situation, bool, &mut Press) -> Drift + 'a {
        let mobility = match &self.running {
            Running::Mobility(film) => Some(film.at_clearance(clearance)),
            _ => None,
        };
        move |at, side_flow, press| match &mobility {
            Some(film) => film.drift(bearing, at, side_flow, press),
            None => self.drift(bearing, at, side_flow, press),
        }
    }

    /// Stiffness and damping about a resting journal; zero before the start.
    pub fn coefficients(&self, bearing: &Bearing, at: &Situation) -> Coefficients {
        let film = self.running.film();
        film.map_or_else(Coefficients::default, |film| film.coefficients(bearing, at))
    }

    /// Columns of cells around the bearing, where the film has any.
    pub fn columns(&self) -> Option<usize> {
        self.running.film()?.columns()
    }

    /// The highest temperature around the bearing, K, where the film has more than one.
    pub fn hottest(&self) -> Option<f64> {
        self.running.film()?.hottest()
    }

    /// Whether the film takes steps of its own.
    pub fn is_transient(&self) -> bool {
        self.running.film().is_some_and(JournalFilm::is_transient)
    }

    /// The film as one that takes steps of its own, if it does.
    pub fn transient(&mut self) -> Option<&mut dyn TransientFilm> {
        self.running.film_mut()?.transient()
    }

    /// Remembers the state of a film that takes steps of its own.
    pub fn keep(&mut self) {
        if let Some(film) = self.transient() {
            film.keep();
        }
    }

    /// Returns to the state that was kept.
    pub fn take_back(&mut self) {
        if let Some(film) = self.transient() {
            film.take_back();
        }
    }
}
