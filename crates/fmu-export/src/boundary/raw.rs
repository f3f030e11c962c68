//! Pointer arguments of C calls, checked for NULL, alignment and size. Whether they point to live memory is the host's
//! word.

use std::{borrow::Cow, ffi::CStr};

use super::{
    refusal::{Outcome, Refusal},
    types::Text,
};

/// `n` values to read. With `n = 0` the pointer may be anything.
///
/// # Safety
/// A pointer that is neither NULL nor misaligned points to `n` values that nobody writes during `'a`.
pub unsafe fn values<'a, T>(pointer: *const T, n: usize, name: &'static str) -> Outcome<&'a [T]> {
    if n == 0 {
        return Ok(&[]);
    }
    check_array(pointer, n, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, n) })
}

/// `n` values to write.
///
/// # Safety
/// As for [`values`], and nobody else reads or writes them during `'a`; they are initialised.
pub unsafe fn values_mut<'a, T>(pointer: *mut T, n: usize, name: &'static str) -> Outcome<&'a mut [T]> {
    if n == 0 {
        return Ok(&mut []);
    }
    check_array(pointer, n, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) })
}

/// One value to write.
///
/// # Safety
/// As for [`values_mut`].
pub unsafe fn place<'a, T>(pointer: *mut T, name: &'static str) -> Outcome<&'a mut T> {
    check_one(pointer, name)?;
    // SAFETY: not NULL and aligned; the caller vouches for the rest.
    Ok(unsafe { &mut *pointer })
}

/// A text.
///
/// # Safety
/// A pointer that is not NULL points to bytes that end with NUL and that nobody writes during `'a`.
pub unsafe fn text<'a>(pointer: Text, name: &'static str) -> Outcome<&'a str> {
    check_one(pointer, name)?;
    // SAFETY: not NULL; the caller vouches for the NUL at its end.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Refusal::Argument {
        name,
        value: text.to_string_lossy().into_owned(),
        why: "strings must be UTF-8",
    })
}

/// `n` texts.
///
/// # Safety
/// As for [`values`] and [`text`].
pub unsafe fn texts<'a>(pointer: *const Text, n: usize, name: &'static str) -> Outcome<Vec<&'a str>> {
    // SAFETY: as the caller vouches.
    unsafe { values(pointer, n, name)?.iter().map(|pointer| text(*pointer, name)).collect() }
}

/// A text in any encoding, with replacement characters where it is not UTF-8. `None` for NULL.
///
/// # Safety
/// As for [`text`].
pub unsafe fn lossy<'a>(pointer: Text) -> Option<Cow<'a, str>> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: not NULL; the caller vouches for the NUL at its end.
    Some(unsafe { CStr::from_ptr(pointer) }.to_string_lossy())
}

fn check_array<T>(pointer: *const T, n: usize, name: &'static str) -> Outcome {
    if pointer.is_null() {
        return Err(Refusal::NullArray(name));
    }
    let fits = n.checked_mul(size_of::<T>()).is_some_and(|size| isize::try_from(size).is_ok());
    if !fits {
        return Err(Refusal::TooMany { name, n });
    }
    check_one(pointer, name)
}

fn check_one<T>(pointer: *const T, name: &'static str) -> Outcome {
    if pointer.is_null() {
        return Err(Refusal::Null(name));
    }
    if !pointer.is_aligned() {
        return Err(Refusal::Misaligned(name));
    }
    Ok(())
}
