//! Reading and writing the elements of variables of FMI 3.0.

use std::ffi::{CStr, CString, c_char};
use std::fmt::Display;
use std::ptr;

use super::element::Element;
use super::functions::Access;
use super::simulation::Model;
use crate::call::Call;
use crate::caller::Caller;
use crate::description::Storage;
use crate::simulation::c_string;
use crate::value::Value;

impl Model {
    pub(super) fn read(&mut self, caller: &mut Caller, element: Element) -> Result<Value, Call> {
        let functions = self.functions;
        Ok(match element.storage {
            Storage::Float32 => {
                let values = self.all(caller, functions.float32, element, 0.0)?;
                Value::Real(values[element.index].into())
            }
            Storage::Float64 => {
                let values = self.all(caller, functions.float64, element, 0.0)?;
                Value::Real(values[element.index])
            }
            Storage::Int8 => self.whole(caller, functions.int8, element)?,
            Storage::UInt8 => self.whole(caller, functions.uint8, element)?,
            Storage::Int16 => self.whole(caller, functions.int16, element)?,
            Storage::UInt16 => self.whole(caller, functions.uint16, element)?,
            Storage::Int32 => self.whole(caller, functions.int32, element)?,
            Storage::UInt32 => self.whole(caller, functions.uint32, element)?,
            Storage::Int64 | Storage::Enumeration => {
                self.whole(caller, functions.int64, element)?
            }
            Storage::UInt64 => self.whole(caller, functions.uint64, element)?,
            Storage::Boolean => {
                let values = self.all(caller, functions.boolean, element, 0)?;
                Value::Boolean(values[element.index] != 0)
            }
            Storage::String => {
                let mut texts = self.texts(caller, element)?;
                let text = std::mem::take(&mut texts[element.index]);
                Value::String(text.to_string_lossy().into_owned())
            }
        })
    }

    pub(super) fn write(
        &mut self,
        caller: &mut Caller,
        element: Element,
        value: &Value,
    ) -> Result<(), Call> {
        let functions = self.functions;
        match (element.storage, value) {
            (Storage::Float32, Value::Real(value)) => {
                let narrow = *value as f32;
                if value.is_finite() && !narrow.is_finite() {
                    return Err(unfit(value, element, functions.float32.setter));
                }
                self.put(caller, functions.float32, element, narrow)
            }
            (Storage::Float64, Value::Real(value)) => {
                self.put(caller, functions.float64, element, *value)
            }
            (Storage::Boolean, Value::Boolean(value)) => {
                self.put(caller, functions.boolean, element, u8::from(*value))
            }
            (Storage::String, Value::String(text)) => self.put_text(caller, element, text),
            (storage, Value::Integer(value)) => match storage {
                Storage::Int8 => self.put_whole(caller, functions.int8, element, *value),
                Storage::UInt8 => self.put_whole(caller, functions.uint8, element, *value),
                Storage::Int16 => self.put_whole(caller, functions.int16, element, *value),
                Storage::UInt16 => self.put_whole(caller, functions.uint16, element, *value),
                Storage::Int32 => self.put_whole(caller, functions.int32, element, *value),
                Storage::UInt32 => self.put_whole(caller, functions.uint32, element, *value),
                Storage::Int64 | Storage::Enumeration => {
                    self.put_whole(caller, functions.int64, element, *value)
                }
                Storage::UInt64 => self.put_whole(caller, functions.uint64, element, *value),
                _ => Err(unfit(value, element, "fmi3Set")),
            },
            (_, other) => Err(unfit(&format!("{other:?}"), element, "fmi3Set")),
        }
    }

    /// The values of all elements of a variable, at least one.
    pub(super) fn all<T: Copy>(
        &mut self,
        caller: &mut Caller,
        access: Access<T>,
        element: Element,
        blank: T,
    ) -> Result<Vec<T>, Call> {
        let get = access.get.ok_or_else(|| Call::missing(access.getter))?;
        let mut values = vec![blank; element.of];
        let reference = element.reference;
        // SAFETY: there is one reference, and room for as many values as the variable has.
        let status = caller.call(|| unsafe {
            get(
                self.component,
                &raw const reference,
                1,
                values.as_mut_ptr(),
                values.len(),
            )
        });
        caller.check(access.getter, status)?;
        Ok(values)
    }

    /// Writes one element; the others of its array keep their values.
    fn put<T: Copy>(
        &mut self,
        caller: &mut Caller,
        access: Access<T>,
        element: Element,
        value: T,
    ) -> Result<(), Call> {
        let values = if element.of == 1 {
            vec![value]
        } else {
            let mut values = self.all(caller, access, element, value)?;
            values[element.index] = value;
            values
        };
        self.put_all(caller, access, element, &values)
    }

    fn put_all<T>(
        &mut self,
        caller: &mut Caller,
        access: Access<T>,
        element: Element,
        values: &[T],
    ) -> Result<(), Call> {
        let set = access.set.ok_or_else(|| Call::missing(access.setter))?;
        let reference = element.reference;
        // SAFETY: there is one reference, and as many values as the variable has.
        let status = caller.call(|| unsafe {
            set(
                self.component,
                &raw const reference,
                1,
                values.as_ptr(),
                values.len(),
            )
        });
        caller.check(access.setter, status)
    }

    fn whole<T>(
        &mut self,
        caller: &mut Caller,
        access: Access<T>,
        element: Element,
    ) -> Result<Value, Call>
    where
        T: Copy + Default + Display,
        i64: TryFrom<T>,
    {
        let value = self.all(caller, access, element, T::default())?[element.index];
        let whole = i64::try_from(value).map_err(|_| {
            let why = format!(
                "{value}, the value of the variable with value reference {}, is larger than {}, and cannot be kept here",
                element.reference,
                i64::MAX
            );
            Call::impossible(access.getter, why)
        })?;
        Ok(Value::Integer(whole))
    }

    fn put_whole<T: Copy + TryFrom<i64>>(
        &mut self,
        caller: &mut Caller,
        access: Access<T>,
        element: Element,
        value: i64,
    ) -> Result<(), Call> {
        let fit = T::try_from(value).map_err(|_| unfit(&value, element, access.setter))?;
        self.put(caller, access, element, fit)
    }

    /// The texts of a variable, copied: the FMU's own ones are valid until the next call only.
    fn texts(&mut self, caller: &mut Caller, element: Element) -> Result<Vec<CString>, Call> {
        let access = self.functions.string;
        let texts = self.all(caller, access, element, ptr::null::<c_char>())?;
        let copy = |text: &*const c_char| {
            if text.is_null() {
                return CString::default();
            }
            // SAFETY: FMI 3.0 returns zero-terminated strings that are valid until the next call.
            unsafe { CStr::from_ptr(*text) }.to_owned()
        };
        Ok(texts.iter().map(copy).collect())
    }

    fn put_text(&mut self, caller: &mut Caller, element: Element, text: &str) -> Result<(), Call> {
        let text = c_string(text);
        let texts = if element.of == 1 {
            vec![text]
        } else {
            let mut texts = self.texts(caller, element)?;
            texts[element.index] = text;
            texts
        };
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        self.put_all(caller, self.functions.string, element, &pointers)
    }
}

/// A value that the variable's type cannot hold.
fn unfit(value: &impl Display, element: Element, function: &'static str) -> Call {
    let why = format!("{value} does not fit into {:?}", element.storage);
    Call::impossible(function, why)
}
