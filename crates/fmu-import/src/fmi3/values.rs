//! Reading and writing the elements of variables of FMI 3.0.

use std::{
    ffi::{CStr, CString, c_char},
    ptr, slice,
    sync::Arc,
};

use super::{element::Element, functions::Access, simulation::Model};
use crate::{
    call::{Call, Called, Status},
    component::c_string,
    description::Storage,
    value::{Value, bytes_of, hexadecimal},
};

impl Model {
    /// Reads one element. All elements of an array are read at once, so that reading one after the other takes one call.
    pub fn read(&mut self, number: u32) -> Called<Value> {
        let elements = Arc::clone(&self.elements);
        let element = Element::of(&elements, number)?;
        match &self.array {
            Some((call, reference, values)) if (*call, *reference) == (self.base.caller.calls, element.reference) => {
                Ok(values[element.index].clone())
            }
            _ => {
                let values = self.read_array(element)?;
                let value = values[element.index].clone();
                if element.of > 1 {
                    self.array = Some((self.base.caller.calls, element.reference, values));
                }
                Ok(value)
            }
        }
    }

    /// The values of all elements of a variable.
    fn read_array(&mut self, element: &Element) -> Result<Vec<Value>, Call> {
        let functions = Arc::clone(&self.functions);
        Ok(match element.storage {
            Storage::Float32 => self
                .all(functions.float32, element, 0.0)?
                .into_iter()
                .map(|value: f32| Value::Real(value.into()))
                .collect(),
            Storage::Float64 => self.all(functions.float64, element, 0.0)?.into_iter().map(Value::Real).collect(),
            Storage::Int8 => self.integers(functions.int8, element)?,
            Storage::UInt8 => self.integers(functions.uint8, element)?,
            Storage::Int16 => self.integers(functions.int16, element)?,
            Storage::UInt16 => self.integers(functions.uint16, element)?,
            Storage::Int32 => self.integers(functions.int32, element)?,
            Storage::UInt32 => self.integers(functions.uint32, element)?,
            Storage::Int64 | Storage::Enumeration => self.integers(functions.int64, element)?,
            Storage::UInt64 => self.integers(functions.uint64, element)?,
            Storage::Boolean => {
                self.all(functions.boolean, element, 0)?.into_iter().map(|value| Value::Boolean(value != 0)).collect()
            }
            Storage::Binary => self.binaries(element)?.iter().map(|bytes| Value::String(hexadecimal(bytes))).collect(),
            Storage::Clock => return Err(without_events()),
            Storage::String => {
                self.texts(element)?.iter().map(|text| Value::String(text.to_string_lossy().into_owned())).collect()
            }
        })
    }

    /// Writes one element. The others of its array keep their values: before the initialisation those that were written
    /// or with which the FMU starts, as some FMUs tell none then.
    pub fn write(&mut self, number: u32, value: &Value) -> Result<(), Call> {
        let functions = Arc::clone(&self.functions);
        let elements = Arc::clone(&self.elements);
        let element = Element::of(&elements, number)?;
        let mut array = None;
        if element.of > 1 {
            array = self.array(number, element);
            if let Some(values) = &mut array {
                values[element.index] = value.clone();
            }
        }
        let all = match element.of {
            1 => Some(slice::from_ref(value)),
            _ => array.as_deref(),
        };
        let new = New { element, value, all };
        match element.storage {
            Storage::Float32 => self.put(functions.float32, new, narrow),
            Storage::Float64 => self.put(functions.float64, new, real),
            Storage::Int8 => self.put(functions.int8, new, whole),
            Storage::UInt8 => self.put(functions.uint8, new, whole),
            Storage::Int16 => self.put(functions.int16, new, whole),
            Storage::UInt16 => self.put(functions.uint16, new, whole),
            Storage::Int32 => self.put(functions.int32, new, whole),
            Storage::UInt32 => self.put(functions.uint32, new, whole),
            Storage::Int64 | Storage::Enumeration => self.put(functions.int64, new, whole),
            Storage::UInt64 => self.put(functions.uint64, new, whole),
            Storage::Boolean => self.put(functions.boolean, new, |value| match value {
                Value::Boolean(yes) => Some(u8::from(*yes)),
                _ => None,
            }),
            Storage::String => self.put_text(new),
            Storage::Binary => self.put_binary(new),
            Storage::Clock => Err(without_events()),
        }?;
        if let (Some(written), Some(array)) = (&mut self.written, array) {
            written.insert(element.reference, array);
        }
        Ok(())
    }

    /// The values of an array before the initialisation, where they are known.
    fn array(&self, number: u32, element: &Element) -> Option<Vec<Value>> {
        let written = self.written.as_ref()?;
        if let Some(values) = written.get(&element.reference) {
            return Some(values.clone());
        }
        let first = number as usize - element.index;
        self.elements
            .get(first..first + element.of)?
            .iter()
            .enumerate()
            .map(|(index, other)| {
                let is_known = other.reference == element.reference && other.index == index;
                other.start.clone().filter(|_| is_known)
            })
            .collect()
    }

    /// The values of all elements of a variable, at least one.
    pub fn all<T: Copy>(&mut self, access: Access<T>, element: &Element, blank: T) -> Called<Vec<T>> {
        let mut values = vec![blank; element.of];
        let (reference, into) = (&raw const element.reference, values.as_mut_ptr());
        // SAFETY: there is one reference, and room for as many values as the variable has.
        self.base.call(access.get, |get, of| unsafe { get(of, reference, 1, into, element.of) })?;
        Ok(values)
    }

    fn put<T: Copy + Default>(&mut self, access: Access<T>, new: New, fit: impl Fn(&Value) -> Option<T>) -> Called {
        let values = self.merged(new, access.set.name, fit, |model| model.all(access, new.element, T::default()))?;
        self.put_all(access, new.element, &values)
    }

    /// The values of all elements of a variable with the new one: the others are those that are known, or else those
    /// that the FMU tells.
    fn merged<T>(
        &mut self,
        new: New,
        function: &'static str,
        fit: impl Fn(&Value) -> Option<T>,
        told: impl FnOnce(&mut Self) -> Called<Vec<T>>,
    ) -> Called<Vec<T>> {
        let fit = |value| fit(value).ok_or_else(|| unfit(value, new.element, function));
        if let Some(all) = new.all {
            return all.iter().map(fit).collect();
        }
        let value = fit(new.value)?;
        let mut all = told(self).map_err(|call| self.untold(call))?;
        all[new.element.index] = value;
        Ok(all)
    }

    /// Why an array cannot be set of which the FMU does not tell the other elements.
    fn untold(&self, mut call: Call) -> Call {
        if self.written.is_some() && call.status != Status::Fatal {
            let why = "an array is set as a whole: the description has no start values for its other elements, and the FMU \
                       does not tell them before its initialisation";
            let message = call.message.take();
            call.message = Some(message.map_or(why.to_owned(), |said| format!("{why}: {said}")));
        }
        call
    }

    fn put_all<T>(&mut self, access: Access<T>, element: &Element, values: &[T]) -> Called {
        let (reference, from) = (&raw const element.reference, values.as_ptr());
        // SAFETY: there is one reference, and as many values as the variable has.
        self.base.call(access.set, |set, of| unsafe { set(of, reference, 1, from, values.len()) })
    }

    fn integers<T>(&mut self, access: Access<T>, element: &Element) -> Called<Vec<Value>>
    where
        T: Copy + Default,
        i128: From<T>,
    {
        Ok(self.all(access, element, T::default())?.into_iter().map(|value| Value::Integer(value.into())).collect())
    }

    /// The texts of a variable, copied: the FMU's own ones are valid until the next call only.
    fn texts(&mut self, element: &Element) -> Called<Vec<CString>> {
        let texts = self.all(self.functions.string, element, ptr::null::<c_char>())?;
        let copy = |text: &*const c_char| {
            if text.is_null() {
                return CString::default();
            }
            // SAFETY: FMI 3.0 returns zero-terminated strings that are valid until the next call.
            unsafe { CStr::from_ptr(*text) }.to_owned()
        };
        Ok(texts.iter().map(copy).collect())
    }

    /// The bytes of a binary variable, copied as the texts are.
    fn binaries(&mut self, element: &Element) -> Called<Vec<Vec<u8>>> {
        let mut sizes = vec![0; element.of];
        let mut places = vec![ptr::null::<u8>(); element.of];
        let (reference, of_each, into) = (&raw const element.reference, sizes.as_mut_ptr(), places.as_mut_ptr());
        let get = self.functions.binary.get;
        // SAFETY: there is one reference, and room for as many sizes and places as the variable has elements.
        self.base.call(get, |get, of| unsafe { get(of, reference, 1, of_each, into, element.of) })?;
        let copy = |(place, size): (&*const u8, &usize)| match place.is_null() || *size == 0 {
            true => Vec::new(),
            // SAFETY: FMI 3.0 returns as many bytes as it says, which are valid until the next call.
            false => unsafe { slice::from_raw_parts(*place, *size) }.to_vec(),
        };
        Ok(places.iter().zip(&sizes).map(copy).collect())
    }

    fn put_binary(&mut self, new: New) -> Called {
        let (element, set) = (new.element, self.functions.binary.set);
        let all = self.merged(
            new,
            set.name,
            |value| match value {
                Value::String(digits) => bytes_of(digits),
                _ => None,
            },
            |model| model.binaries(element),
        )?;
        let sizes: Vec<usize> = all.iter().map(Vec::len).collect();
        let places: Vec<*const u8> = all.iter().map(|bytes| bytes.as_ptr()).collect();
        let (reference, sizes, places) = (&raw const element.reference, sizes.as_ptr(), places.as_ptr());
        // SAFETY: there is one reference, and as many sizes and places as the variable has elements.
        self.base.call(set, |set, of| unsafe { set(of, reference, 1, sizes, places, element.of) })
    }

    fn put_text(&mut self, new: New) -> Called {
        let (element, access) = (new.element, self.functions.string);
        let texts = self.merged(
            new,
            access.set.name,
            |value| match value {
                Value::String(text) => Some(c_string(text)),
                _ => None,
            },
            |model| model.texts(element),
        )?;
        // The texts live until the call is over.
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        self.put_all(access, element, &pointers)
    }
}

/// A value for an element.
#[derive(Clone, Copy)]
struct New<'a> {
    element: &'a Element,
    value: &'a Value,
    /// The values of all elements of its variable with it, where they are known.
    all: Option<&'a [Value]>,
}

fn real(value: &Value) -> Option<f64> {
    match value {
        Value::Real(value) => Some(*value),
        _ => None,
    }
}

/// A number of 32 bits, if it is not too large for one.
fn narrow(value: &Value) -> Option<f32> {
    let value = real(value)?;
    let narrow = value as f32;
    (narrow.is_finite() || !value.is_finite()).then_some(narrow)
}

fn whole<T: TryFrom<i128>>(value: &Value) -> Option<T> {
    match value {
        Value::Integer(value) => T::try_from(*value).ok(),
        _ => None,
    }
}

/// Why a clock is neither read nor set.
fn without_events() -> Call {
    let why = "the clocks of an FMU without event mode do not tick".to_owned();
    Call::impossible("fmi3GetClock", why)
}

/// A value that the variable's type cannot hold.
fn unfit(value: &Value, element: &Element, function: &'static str) -> Call {
    let value = match value {
        Value::Real(value) => format!("{value:?}"),
        Value::Integer(value) => value.to_string(),
        other => format!("{other:?}"),
    };
    Call::impossible(function, format!("{value} does not fit into {:?}", element.storage))
}
