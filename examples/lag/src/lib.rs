//! A first-order lag with a variable of every type, for tests of the FMI boundary.
//!
//! `tau dy/dt = gain u - y` with `u` linear within a step, solved exactly.

use serde::{Deserialize, Serialize};

use fmu_export::declare::{input, output, parameter, tunable, variable};
use fmu_export::field;
use fmu_export::model::{
    Access, Continuous, Exchange, Experiment, Fault, Info, Kind, Log, Model, Role, State, Variable,
};
use fmu_export::units::{ONE, PER_SECOND, SECOND};

/// The lag: parameters, inputs, state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lag {
    input: f64,
    slope: f64,
    constant: f64,
    gain: f64,
    initial: f64,
    state: f64,
    steps: i32,
    trouble: i32,
    inverted: bool,
    label: String,
    /// The time that the lag has reached, s; `None` before the first step.
    reached: Option<f64>,
    start: f64,
}

impl Default for Lag {
    fn default() -> Self {
        Self {
            input: 0.0,
            slope: 0.0,
            constant: 0.5,
            gain: 2.0,
            initial: 1.0,
            state: 0.0,
            steps: 0,
            trouble: 1,
            inverted: false,
            label: "lag".to_owned(),
            reached: None,
            start: 0.0,
        }
    }
}

impl Lag {
    fn sign(&self) -> f64 {
        if self.inverted { -1.0 } else { 1.0 }
    }

    fn derivative(&self) -> f64 {
        self.sign() * (self.gain * self.input - self.state) / self.constant
    }

    /// A text that changes with every step. It is put together when it is read: a step should cost next to nothing.
    fn report(&self) -> String {
        match self.reached {
            Some(time) => format!("{} is at {time} s", self.label),
            None => format!("{} starts at {} s", self.label, self.start),
        }
    }
}

fmu_export::enumerations! {
    /// The fault of the next step.
    TROUBLE = "Trouble", "What goes wrong in the next step", [
        None = 1 "Nothing",
        Discard = 2 "The step cannot be computed",
        Error = 3 "An input is not usable",
        Panic = 4 "A bug"
    ];
}

static VARIABLES: [Variable<Lag>; 11] = [
    input("input", &ONE, field!(Lag: input), "The lag's input")
        .within(-1e6, 1e6)
        .about(1.0)
        .slope(|lag, rate| lag.slope = rate),
    parameter("timeConstant", &SECOND, field!(Lag: constant), "The lag's time constant").within(1e-3, 1e6).about(1.0),
    tunable("gain", &ONE, field!(Lag: gain), "The lag's gain").within(-1e6, 1e6).about(1.0),
    parameter("initialState", &ONE, field!(Lag: initial), "The lag's output at the start").within(-1e6, 1e6).about(1.0),
    output("output", &ONE, |lag: &Lag| lag.sign() * lag.state, "The lag's output")
        .within(-1e12, 1e12)
        .about(1.0)
        .derivative(Lag::derivative),
    output("feed", &ONE, |lag: &Lag| lag.sign() * lag.gain * lag.input, "The value that the output tends to")
        .within(-1e12, 1e12)
        .about(1.0)
        .depends_on(&["input", "inverted"]),
    variable(
        "trouble",
        Role::TunableParameter,
        Kind::Enumeration { access: field!(Lag: trouble), of: &TROUBLE },
        "What goes wrong in the next step",
    ),
    variable(
        "inverted",
        Role::Input,
        Kind::Boolean { access: field!(Lag: inverted) },
        "Whether the outputs change their sign",
    ),
    variable(
        "label",
        Role::Parameter,
        Kind::String { access: fmu_export::text!(Lag: label) },
        "A name with <&\"> in it",
    ),
    variable(
        "steps",
        Role::Output,
        Kind::Integer { access: Access { get: |lag| lag.steps, set: None }, min: Some(0), max: None },
        "Number of steps done",
    ),
    variable(
        "report",
        Role::Output,
        Kind::String { access: Access { get: Lag::report, set: None } },
        "The time that the lag has reached, in words",
    ),
];

impl Model for Lag {
    const INFO: Info = Info {
        name: "First-order lag",
        identifier: "Lag",
        log_categories: &[("lag", "Every step that the lag makes")],
        ..fmu_export::info!()
    };

    const EXCHANGE: Option<Exchange<Self>> = Some(Exchange::of());

    /// A host may look into a step eight times in each time constant.
    const INNER_STEP: Option<fn(&Self, f64) -> f64> = Some(|lag, _| lag.constant / 8.0);

    fn variables() -> &'static [Variable<Self>] {
        &VARIABLES
    }

    fn initialise(&mut self, experiment: &Experiment<'_>, log: &mut dyn Log) -> Result<(), Fault> {
        self.state = self.initial;
        self.start = experiment.start;
        log.log("lag", format_args!("{} 100 %s%n", self.report()));
        Ok(())
    }

    /// With `u = u0 + s t`, the solution is `y = a + b t + (y0 - a) exp(-t/tau)`, where
    /// `b = gain s` and `a = gain u0 - tau b`.
    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault> {
        match self.trouble {
            2 => return Err(Fault::Failed("the lag discards this step".to_owned())),
            3 => return Err(Fault::Invalid("the lag does not like its input".to_owned())),
            4 => panic!("the lag panics"),
            _ => {}
        }
        // Without differences of large numbers: a jump may come as a steep slope in a short step.
        let decayed = -(-step / self.constant).exp_m1();
        let towards = self.gain * self.input - self.state;
        let ahead = self.gain * self.slope * (step - self.constant * decayed);
        self.state += towards * decayed + ahead;
        self.input += self.slope * step;
        self.steps = self.steps.wrapping_add(1);
        self.reached = Some(time + step);
        log.log("lag", format_args!("step to {} s", time + step));
        Ok(())
    }
}

static STATES: [State<Lag>; 1] = [State {
    name: "state",
    description: "The lag's state: its output, but for the sign",
    unit: &ONE,
    rate_unit: &PER_SECOND,
    nominal: 1.0,
    get: |lag| lag.state,
    set: |lag, value| lag.state = value,
}];

impl Continuous for Lag {
    fn states() -> &'static [State<Self>] {
        &STATES
    }

    /// The lag's own steps are what it counts.
    fn without() -> &'static [&'static str] {
        &["steps"]
    }

    fn set_time(&mut self, time: f64) {
        self.reached = Some(time);
    }

    /// The troubles of a step are those of the rates, too.
    fn rates(&self, rates: &mut [f64]) -> Result<(), Fault> {
        match self.trouble {
            2 => return Err(Fault::Failed("the lag has no rate here".to_owned())),
            3 => return Err(Fault::Invalid("the lag does not like its input".to_owned())),
            4 => panic!("the lag panics"),
            _ => {}
        }
        if let [rate] = rates {
            *rate = (self.gain * self.input - self.state) / self.constant;
        }
        Ok(())
    }
}

fmu_export::export!(Lag);

#[cfg(test)]
mod tests {
    use super::*;

    /// A jump that is recorded as a line over a picosecond leaves the state where it was.
    #[test]
    fn a_steep_slope_in_a_short_step_costs_no_digits() {
        let mut lag = Lag { input: 1.0, slope: -2e12, state: 0.3, ..Lag::default() };
        lag.advance(0.0, 1e-12, &mut ()).unwrap();
        assert!((lag.state - 0.3).abs() < 1e-11, "{}", lag.state);
        assert!((lag.input + 1.0).abs() < 1e-12, "{}", lag.input);
    }
}
