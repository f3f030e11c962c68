//! Reading and writing variables. A value reference is the variable's index in the model's table.

use std::{ffi::CString, fmt::Debug};

use super::{
    exchange::existing,
    instance::Instance,
    logger::c_string,
    lookup::variable_of,
    phase::Phase,
    refusal::{Outcome, Refusal},
    types::{Real, Text, ValueReference},
    version::Version,
};
use crate::model::{Access, Kind, Model, Role, Variable, inside};

/// The refusal for a variable of another type than the function's.
pub fn wrong_type<M>(version: Version, variable: &Variable<M>, asked: &'static str) -> Refusal {
    Refusal::Type { name: variable.name, is: version.type_name(variable), asked }
}

/// The value reference of the independent variable, which FMI 3.0 lists. It is far above those of the table, which may
/// grow, and a positive number in every signed type.
pub const TIME: ValueReference = i32::MAX as ValueReference;

/// The kinds of variables that a function for whole numbers takes.
pub struct Whole {
    integers: bool,
    items: bool,
    /// The types that the host asks for with it.
    asked: &'static str,
}

/// Integers and enumerations (FMI 2.0).
pub const INTEGER: Whole = Whole { integers: true, items: true, asked: "Integer or Enumeration" };

/// Integers (FMI 3.0).
pub const INT32: Whole = Whole { integers: true, items: false, asked: "Int32" };

/// Enumerations (FMI 3.0).
pub const INT64: Whole = Whole { integers: false, items: true, asked: "Int64 or Enumeration" };

/// Whether the host may set a variable of this role in this phase.
pub fn check_settable<M>(variable: &Variable<M>, phase: Phase) -> Outcome {
    let (role, settable) = match variable.role {
        // While a host integrates, it may change what is continuous, and nothing else.
        Role::Input => {
            let real = matches!(variable.kind, Kind::Real(_));
            ("an input", real || phase != Phase::Continuous)
        }
        Role::TunableParameter => ("a tunable parameter", phase != Phase::Continuous),
        Role::Parameter => {
            let before = matches!(phase, Phase::Instantiated | Phase::Initialization);
            ("a fixed parameter", before)
        }
        Role::Output => ("an output", false),
        Role::Local => ("a local variable", false),
    };
    if settable {
        return Ok(());
    }
    Err(Refusal::NotSettable { name: variable.name, role, phase })
}

impl<M: Model> Instance<M> {
    /// Reads one value after another with `read`, which gives none for a variable of another type than was `asked` for.
    fn get<T>(
        &mut self,
        asked: &'static str,
        references: &[ValueReference],
        values: &mut [T],
        read: impl Fn(&Kind<M>, &M) -> Option<T>,
    ) -> Outcome {
        self.get_each(references, values, |instance, reference| {
            let variable = variable_of::<M>(reference)?;
            let now = read(&variable.kind, &instance.run.model);
            now.ok_or_else(|| wrong_type(instance.version, variable, asked))
        })
    }

    fn get_each<T>(
        &mut self,
        references: &[ValueReference],
        values: &mut [T],
        read: impl Fn(&Self, ValueReference) -> Outcome<T>,
    ) -> Outcome {
        self.check_intermediate(references, false)?;
        self.refresh()?;
        for (reference, value) in references.iter().zip(values) {
            *value = read(self, *reference)?;
        }
        Ok(())
    }

    /// Reads real values. In Model Exchange the states are the host's, and not every output exists at every state: the
    /// solver then tries a shorter step.
    pub fn get_real(&mut self, references: &[ValueReference], values: &mut [Real]) -> Outcome {
        let (version, exchange) = (self.version, self.run.exchange);
        self.get_each(references, values, |instance, reference| {
            let variable = variable_of::<M>(reference);
            let value = match &variable {
                Ok(Variable { kind: Kind::Real(real), .. }) => (real.access.get)(&instance.run.model),
                Ok(variable) => return Err(wrong_type(version, variable, version.real())),
                Err(_) => instance.unlisted(reference)?.ok_or(Refusal::UnknownReference(reference))?,
            };
            if exchange && !value.is_finite() {
                existing(variable.map_or("the value", |variable| variable.name), value)?;
            }
            Ok(value)
        })
    }

    /// The value of a variable that is not in the model's table.
    #[cold]
    fn unlisted(&self, reference: ValueReference) -> Outcome<Option<Real>> {
        if reference == TIME && self.version == Version::Three {
            return Ok(Some(self.run.time));
        }
        self.state_or_rate(reference)
    }

    /// Reads whole numbers of some kinds.
    pub fn get_whole<T: From<i32>>(&mut self, of: Whole, references: &[ValueReference], values: &mut [T]) -> Outcome {
        self.get(of.asked, references, values, |kind, model| match kind {
            Kind::Integer { access, .. } if of.integers => Some((access.get)(model).into()),
            Kind::Enumeration { access, .. } if of.items => Some((access.get)(model).into()),
            _ => None,
        })
    }

    /// Reads booleans: 0 or 1.
    pub fn get_boolean<T: From<bool>>(&mut self, references: &[ValueReference], values: &mut [T]) -> Outcome {
        self.get("Boolean", references, values, |kind, model| match kind {
            Kind::Boolean { access } => Some((access.get)(model).into()),
            _ => None,
        })
    }

    /// Reads clocks: whether each has ticked.
    pub fn get_clock(&mut self, references: &[ValueReference], values: &mut [u8]) -> Outcome {
        self.get("Clock", references, values, |kind, model| match kind {
            Kind::Clock { ticked } => Some(ticked(model).into()),
            _ => None,
        })
    }

    /// Refuses to set clocks, all of which are outputs.
    pub fn set_clock(&mut self, references: &[ValueReference], values: &[u8]) -> Outcome {
        let version = self.version;
        self.set(references, values, |variable, _, _| Err(wrong_type(version, variable, "Clock")))
    }

    /// Refuses values of a type that no variable of a model has.
    pub fn refuse_type(&mut self, references: &[ValueReference], asked: &'static str) -> Outcome {
        match references.first() {
            None => Ok(()),
            Some(first) => Err(wrong_type(self.version, variable_of::<M>(*first)?, asked)),
        }
    }

    /// Reads texts. The host may keep the pointer to a text until it reads the same variable again.
    pub fn get_string(&mut self, references: &[ValueReference], values: &mut [Text]) -> Outcome {
        let mut texts = vec![CString::default(); references.len()];
        self.get("String", references, &mut texts, |kind, model| match kind {
            Kind::String { access } => Some(c_string(&(access.get)(model))),
            _ => None,
        })?;
        for ((reference, text), value) in references.iter().zip(texts).zip(values) {
            let place = &mut self.texts[*reference as usize];
            if place.as_ref() != Some(&text) {
                *place = Some(text);
            }
            *value = place.as_ref().map_or(std::ptr::null(), |text| text.as_ptr());
        }
        Ok(())
    }

    /// Checks all values, then writes them all: a call that is refused changes nothing. `put` does both, and checks alone where it
    /// gets no model.
    fn set<T: Copy>(
        &mut self,
        references: &[ValueReference],
        values: &[T],
        put: impl Fn(&Variable<M>, T, Option<&mut M>) -> Outcome,
    ) -> Outcome {
        self.check_intermediate(references, true)?;
        // First check.
        for (reference, value) in references.iter().zip(values) {
            let variable = variable_of::<M>(*reference).map_err(|unknown| match self.state_or_rate(*reference) {
                Ok(Some(_)) => Refusal::Absent("a state is set by SetContinuousStates, and its derivative is computed"),
                _ => unknown,
            })?;
            check_settable(variable, self.run.phase)?;
            put(variable, *value, None)?;
        }
        // Then write.
        let model = self.run.seed.as_mut().unwrap_or(&mut self.run.model);
        for (reference, value) in references.iter().zip(values) {
            put(variable_of::<M>(*reference)?, *value, Some(model))?;
        }
        self.run.stale = true;
        self.run.differentiated = false;
        Ok(())
    }

    /// Writes real values.
    pub fn set_real(&mut self, references: &[ValueReference], values: &[Real]) -> Outcome {
        let version = self.version;
        self.set(references, values, |variable, value, model| {
            let Kind::Real(real) = &variable.kind else { return Err(wrong_type(version, variable, version.real())) };
            if !value.is_finite() || !inside(value, real.min, real.max) {
                return Err(outside(variable, value, real.min, real.max));
            }
            write(variable, &real.access, &value, model)
        })
    }

    /// Writes whole numbers of some kinds.
    pub fn set_whole<T: Copy + Into<i64>>(
        &mut self,
        of: Whole,
        references: &[ValueReference],
        values: &[T],
    ) -> Outcome {
        let version = self.version;
        self.set(references, values, |variable, value, model| {
            let value: i64 = value.into();
            match &variable.kind {
                Kind::Integer { access, min, max } if of.integers => {
                    let (min, max) = (min.map(i64::from), max.map(i64::from));
                    match i32::try_from(value) {
                        Ok(small) if inside(value, min, max) => write(variable, access, &small, model),
                        _ => Err(outside(variable, value, min, max)),
                    }
                }
                Kind::Enumeration { access, of: known } if of.items => {
                    let item = known.items.iter().find(|item| i64::from(item.value) == value).ok_or_else(|| {
                        Refusal::Value {
                            name: variable.name,
                            value: value.to_string(),
                            allowed: format!("one of {}", known.listed()),
                        }
                    })?;
                    write(variable, access, &item.value, model)
                }
                _ => Err(wrong_type(version, variable, of.asked)),
            }
        })
    }

    /// Writes booleans: 0 is false, everything else is true.
    pub fn set_boolean<T: Copy + Default + PartialEq>(
        &mut self,
        references: &[ValueReference],
        values: &[T],
    ) -> Outcome {
        let version = self.version;
        self.set(references, values, |variable, value, model| match &variable.kind {
            Kind::Boolean { access } => write(variable, access, &(value != T::default()), model),
            _ => Err(wrong_type(version, variable, "Boolean")),
        })
    }

    /// Writes texts.
    pub fn set_string(&mut self, references: &[ValueReference], values: &[&str]) -> Outcome {
        let version = self.version;
        self.set(references, values, |variable, value, model| match &variable.kind {
            Kind::String { access } => write(variable, access, value, model),
            _ => Err(wrong_type(version, variable, "String")),
        })
    }
}

/// Writes a checked value where there is a model; without one it checks alone that the variable can be written.
fn write<M, T: ?Sized, R>(
    variable: &Variable<M>,
    access: &Access<M, T, R>,
    value: &T,
    model: Option<&mut M>,
) -> Outcome {
    let set = access.set.ok_or(Refusal::Computed(variable.name))?;
    if let Some(model) = model {
        set(model, value);
    }
    Ok(())
}

fn outside<M, T: Debug>(variable: &Variable<M>, value: T, min: Option<T>, max: Option<T>) -> Refusal {
    let allowed = match (min, max) {
        (Some(min), Some(max)) => format!("from {min:?} to {max:?}"),
        (Some(min), None) => format!("at least {min:?}"),
        (None, Some(max)) => format!("at most {max:?}"),
        (None, None) => "a finite number".to_owned(),
    };
    Refusal::Value { name: variable.name, value: format!("{value:?}"), allowed }
}
