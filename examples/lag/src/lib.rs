//! A first-order lag with a variable of every type: small enough to check by hand.
//!
//! `tau dy/dt = gain u - y` with `u` linear within a step, solved exactly.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use fmu_export::model::{
    Access, DisplayUnit, Enumeration, Experiment, Fault, Info, Item, Kind, Log, Model, Role, Unit,
    Variable,
};

/// The lag: parameters, input, state and outputs.
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
    report: String,
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
            report: String::new(),
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
}

const SECOND: Unit = Unit {
    name: "s",
    exponents: [0, 0, 1, 0, 0],
    display: &[DisplayUnit {
        name: "ms",
        factor: 1000.0,
        offset: 0.0,
    }],
    relative: false,
};
const ONE: Unit = Unit {
    name: "1",
    exponents: [0; 5],
    display: &[],
    relative: false,
};
const TROUBLE: Enumeration = Enumeration {
    name: "Trouble",
    description: "What goes wrong in the next step",
    items: &[
        Item {
            name: "None",
            value: 1,
            description: "Nothing",
        },
        Item {
            name: "Discard",
            value: 2,
            description: "The step cannot be computed",
        },
        Item {
            name: "Error",
            value: 3,
            description: "An input is not usable",
        },
        Item {
            name: "Panic",
            value: 4,
            description: "A bug",
        },
    ],
};

macro_rules! real {
    ($name:literal, $role:ident, $unit:ident, $get:expr, $set:expr, $slope:expr, $derivative:expr, $min:expr) => {
        Variable {
            name: $name,
            description: concat!("The lag's ", $name),
            role: Role::$role,
            depends_on: &[],
            kind: Kind::Real {
                access: Access {
                    get: $get,
                    set: $set,
                },
                unit: &$unit,
                display: None,
                min: $min,
                max: Some(1e6),
                nominal: Some(1.0),
                slope: $slope,
                derivative: $derivative,
            },
        }
    };
}

static VARIABLES: [Variable<Lag>; 11] = [
    real!(
        "input",
        Input,
        ONE,
        |m| m.input,
        Some(|m, v| m.input = *v),
        Some(|m, v| m.slope = v),
        None,
        Some(-1e6)
    ),
    real!(
        "timeConstant",
        Parameter,
        SECOND,
        |m| m.constant,
        Some(|m, v| m.constant = *v),
        None,
        None,
        Some(1e-3)
    ),
    real!(
        "gain",
        TunableParameter,
        ONE,
        |m| m.gain,
        Some(|m, v| m.gain = *v),
        None,
        None,
        Some(-1e6)
    ),
    real!(
        "initialState",
        Parameter,
        ONE,
        |m| m.initial,
        Some(|m, v| m.initial = *v),
        None,
        None,
        Some(-1e6)
    ),
    real!(
        "output",
        Output,
        ONE,
        |m| m.sign() * m.state,
        None,
        None,
        Some(Lag::derivative),
        Some(-1e6)
    ),
    Variable {
        depends_on: &["input", "inverted"],
        ..real!(
            "feed",
            Output,
            ONE,
            |m| m.sign() * m.gain * m.input,
            None,
            None,
            None,
            Some(-1e12)
        )
    },
    Variable {
        name: "trouble",
        description: "What goes wrong in the next step",
        role: Role::TunableParameter,
        depends_on: &[],
        kind: Kind::Enumeration {
            access: Access {
                get: |m| m.trouble,
                set: Some(|m, v| m.trouble = *v),
            },
            of: &TROUBLE,
        },
    },
    Variable {
        name: "inverted",
        description: "Whether the outputs change their sign",
        role: Role::Input,
        depends_on: &[],
        kind: Kind::Boolean {
            access: Access {
                get: |m| m.inverted,
                set: Some(|m, v| m.inverted = *v),
            },
        },
    },
    Variable {
        name: "label",
        description: "A name with <&\"> in it",
        role: Role::Parameter,
        depends_on: &[],
        kind: Kind::String {
            access: Access {
                get: |m| m.label.clone(),
                set: Some(|m, v| m.label = v.to_owned()),
            },
        },
    },
    Variable {
        name: "steps",
        description: "Number of steps done",
        role: Role::Output,
        depends_on: &[],
        kind: Kind::Integer {
            access: Access {
                get: |m| m.steps,
                set: None,
            },
            min: Some(0),
            max: None,
        },
    },
    Variable {
        name: "report",
        description: "What happened last",
        role: Role::Output,
        depends_on: &[],
        kind: Kind::String {
            access: Access {
                get: |m| m.report.clone(),
                set: None,
            },
        },
    },
];

impl Model for Lag {
    const INFO: Info = Info {
        name: "First-order lag",
        identifier: "Lag",
        description: "A first-order lag with a variable of every type",
        default_step: 0.01,
        default_stop: 1.0,
        default_tolerance: 1e-6,
        log_categories: &[("lag", "What the lag does")],
    };

    fn variables() -> &'static [Variable<Self>] {
        &VARIABLES
    }

    fn initialise(&mut self, experiment: &Experiment<'_>, log: &mut dyn Log) -> Result<(), Fault> {
        self.state = self.initial;
        self.report = format!("{} starts at {} s", self.label, experiment.start);
        log.log("lag", format_args!("{} 100 %s%n", self.report));
        Ok(())
    }

    fn update(&mut self) -> Result<(), Fault> {
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
        let b = self.gain * self.slope;
        let a = self.gain * self.input - self.constant * b;
        self.state = a + b * step + (self.state - a) * (-step / self.constant).exp();
        self.input += self.slope * step;
        self.steps = self.steps.wrapping_add(1);
        self.report.clear();
        let _ = write!(self.report, "{} is at {} s", self.label, time + step);
        log.log("lag", format_args!("step to {} s", time + step));
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        postcard::to_stdvec(self).unwrap_or_default()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        *self = postcard::from_bytes(bytes).map_err(|error| Fault::Invalid(error.to_string()))?;
        Ok(())
    }
}

fmu_export::export!(Lag);
