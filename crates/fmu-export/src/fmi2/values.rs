//! Reading and writing variables. A value reference is the variable's index in the model's table.

use std::ffi::CString;
use std::fmt::Debug;

use super::instance::Instance;
use super::logger::c_string;
use super::phase::Phase;
use super::refusal::{Outcome, Refusal};
use super::types::{Real, Status, Text, ValueReference};
use crate::model::{Access, Kind, Model, Role, Variable};

/// The variable of a value reference.
pub fn variable<M: Model>(reference: ValueReference) -> Outcome<&'static Variable<M>> {
    usize::try_from(reference)
        .ok()
        .and_then(|index| M::variables().get(index))
        .ok_or(Refusal::UnknownReference(reference))
}

/// The refusal for a variable of another type than the function's.
pub fn wrong_type<M>(variable: &Variable<M>, asked: &'static str) -> Refusal {
    Refusal::Type {
        name: variable.name,
        is: variable.type_name(),
        asked,
    }
}

/// Whether the host may set a variable of this role in this phase.
pub fn check_settable<M>(variable: &Variable<M>, phase: Phase) -> Outcome<()> {
    let (role, settable) = match variable.role {
        Role::Input => ("an input", true),
        Role::TunableParameter => ("a tunable parameter", true),
        Role::Parameter => ("a fixed parameter", phase != Phase::StepComplete),
        Role::Output => ("an output", false),
        Role::Local => ("a local variable", false),
    };
    if settable {
        return Ok(());
    }
    Err(Refusal::NotSettable {
        name: variable.name,
        role,
        phase,
    })
}

impl<M: Model> Instance<M> {
    /// Reads one value after another with `read` into `values`.
    fn get<T>(
        &mut self,
        references: &[ValueReference],
        values: &mut [T],
        read: impl Fn(&Variable<M>, &M) -> Outcome<T>,
    ) -> Outcome {
        self.refresh()?;
        for (reference, value) in references.iter().zip(values) {
            *value = read(variable::<M>(*reference)?, &self.run.model)?;
        }
        Ok(Status::Ok)
    }

    /// `fmi2GetReal`.
    pub fn get_real(&mut self, references: &[ValueReference], values: &mut [Real]) -> Outcome {
        self.get(references, values, |variable, model| match &variable.kind {
            Kind::Real { access, .. } => Ok((access.get)(model)),
            _ => Err(wrong_type(variable, "Real")),
        })
    }

    /// `fmi2GetInteger`, for enumerations too.
    pub fn get_integer(&mut self, references: &[ValueReference], values: &mut [i32]) -> Outcome {
        self.get(references, values, |variable, model| match &variable.kind {
            Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => {
                Ok((access.get)(model))
            }
            _ => Err(wrong_type(variable, "Integer or Enumeration")),
        })
    }

    /// `fmi2GetBoolean`.
    pub fn get_boolean(&mut self, references: &[ValueReference], values: &mut [i32]) -> Outcome {
        self.get(references, values, |variable, model| match &variable.kind {
            Kind::Boolean { access } => Ok((access.get)(model).into()),
            _ => Err(wrong_type(variable, "Boolean")),
        })
    }

    /// `fmi2GetString`. The host may keep the pointer to a text until it reads the same variable again.
    pub fn get_string(&mut self, references: &[ValueReference], values: &mut [Text]) -> Outcome {
        let mut texts = vec![CString::default(); references.len()];
        self.get(references, &mut texts, |variable, model| {
            match &variable.kind {
                Kind::String { access } => Ok(c_string(&(access.get)(model))),
                _ => Err(wrong_type(variable, "String")),
            }
        })?;
        for ((reference, text), value) in references.iter().zip(texts).zip(values) {
            let place = &mut self.texts[*reference as usize];
            if place.as_ref() != Some(&text) {
                *place = Some(text);
            }
            *value = place
                .as_ref()
                .map_or(std::ptr::null(), |text| text.as_ptr());
        }
        Ok(Status::Ok)
    }

    /// Checks all values with `put`, then writes them all: a call that is refused changes nothing.
    fn set<T: Copy>(
        &mut self,
        references: &[ValueReference],
        values: &[T],
        put: impl Fn(&Variable<M>, T, Option<&mut M>) -> Outcome<()>,
    ) -> Outcome {
        for (reference, value) in references.iter().zip(values) {
            let variable = variable::<M>(*reference)?;
            check_settable(variable, self.run.phase)?;
            put(variable, *value, None)?;
        }
        let model = self.run.seed.as_mut().unwrap_or(&mut self.run.model);
        for (reference, value) in references.iter().zip(values) {
            put(variable::<M>(*reference)?, *value, Some(model))?;
        }
        self.run.stale = true;
        self.run.differentiated = false;
        Ok(Status::Ok)
    }

    /// `fmi2SetReal`.
    pub fn set_real(&mut self, references: &[ValueReference], values: &[Real]) -> Outcome {
        self.set(references, values, |variable, value, model| {
            let Kind::Real {
                access, min, max, ..
            } = &variable.kind
            else {
                return Err(wrong_type(variable, "Real"));
            };
            if !value.is_finite() || !inside(value, *min, *max) {
                return Err(outside(variable, value, *min, *max));
            }
            write(variable, access, &value, model)
        })
    }

    /// `fmi2SetInteger`, for enumerations too.
    pub fn set_integer(&mut self, references: &[ValueReference], values: &[i32]) -> Outcome {
        self.set(
            references,
            values,
            |variable, value, model| match &variable.kind {
                Kind::Integer { access, min, max } => {
                    if !inside(value, *min, *max) {
                        return Err(outside(variable, value, *min, *max));
                    }
                    write(variable, access, &value, model)
                }
                Kind::Enumeration { access, of } => {
                    if !of.items.iter().any(|item| item.value == value) {
                        let items = of
                            .items
                            .iter()
                            .map(|item| format!("{} ({})", item.value, item.name));
                        return Err(Refusal::Value {
                            name: variable.name,
                            value: value.to_string(),
                            allowed: format!("one of {}", items.collect::<Vec<_>>().join(", ")),
                        });
                    }
                    write(variable, access, &value, model)
                }
                _ => Err(wrong_type(variable, "Integer or Enumeration")),
            },
        )
    }

    /// `fmi2SetBoolean`.
    pub fn set_boolean(&mut self, references: &[ValueReference], values: &[i32]) -> Outcome {
        self.set(
            references,
            values,
            |variable, value, model| match &variable.kind {
                Kind::Boolean { access } => write(variable, access, &(value != 0), model),
                _ => Err(wrong_type(variable, "Boolean")),
            },
        )
    }

    /// `fmi2SetString`.
    pub fn set_string(&mut self, references: &[ValueReference], values: &[&str]) -> Outcome {
        self.set(
            references,
            values,
            |variable, value, model| match &variable.kind {
                Kind::String { access } => write(variable, access, value, model),
                _ => Err(wrong_type(variable, "String")),
            },
        )
    }
}

/// Writes a checked value if there is a model to write it to; else checks that it could be written.
fn write<M, T: ?Sized, R>(
    variable: &Variable<M>,
    access: &Access<M, T, R>,
    value: &T,
    model: Option<&mut M>,
) -> Outcome<()> {
    let set = access.set.ok_or_else(|| Refusal::Value {
        name: variable.name,
        value: "a value".to_owned(),
        allowed: "left alone, as the model computes it".to_owned(),
    })?;
    if let Some(model) = model {
        set(model, value);
    }
    Ok(())
}

/// Whether a value lies within the bounds, if there are any.
pub fn inside<T: PartialOrd>(value: T, min: Option<T>, max: Option<T>) -> bool {
    min.is_none_or(|min| value >= min) && max.is_none_or(|max| value <= max)
}

fn outside<M, T: Debug>(
    variable: &Variable<M>,
    value: T,
    min: Option<T>,
    max: Option<T>,
) -> Refusal {
    let allowed = match (min, max) {
        (Some(min), Some(max)) => format!("from {min:?} to {max:?}"),
        (Some(min), None) => format!("at least {min:?}"),
        (None, Some(max)) => format!("at most {max:?}"),
        (None, None) => "a finite number".to_owned(),
    };
    Refusal::Value {
        name: variable.name,
        value: format!("{value:?}"),
        allowed,
    }
}
