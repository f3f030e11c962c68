//! Raw pointers of C arguments, checked as far as pointers can be checked.

use std::borrow::Cow;
use std::ffi::CStr;

use super::refusal::{Outcome, Refusal};
use super::types::Text;

/// `n` values to read. No values need no pointer.
///
/// # Safety
/// A pointer that is neither NULL nor misaligned points to `n` values that nobody writes during `'a`.
pub unsafe fn values<'a, T>(pointer: *const T, n: usize, name: &'static str) -> Outcome<&'a [T]> {
    if n == 0 {
        return Ok(&[]);
    }
    check(pointer, n, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, n) })
}

/// `n` values to write.
///
/// # Safety
/// As for [`values`], and nobody else reads or writes them during `'a`; they are initialised.
pub unsafe fn values_mut<'a, T>(
    pointer: *mut T,
    n: usize,
    name: &'static str,
) -> Outcome<&'a mut [T]> {
    if n == 0 {
        return Ok(&mut []);
    }
    check(pointer, n, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) })
}

/// One value to write.
///
/// # Safety
/// As for [`values_mut`].
pub unsafe fn place<'a, T>(pointer: *mut T, name: &'static str) -> Outcome<&'a mut T> {
    check(pointer, 1, name)?;
    // SAFETY: not NULL and aligned; the caller vouches for the rest.
    Ok(unsafe { &mut *pointer })
}

/// A text.
///
/// # Safety
/// A pointer that is not NULL points to bytes that end with NUL and that nobody writes during `'a`.
pub unsafe fn text<'a>(pointer: Text, name: &'static str) -> Outcome<&'a str> {
    check(pointer, 1, name)?;
    // SAFETY: not NULL; the caller vouches for the NUL at its end.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Refusal::Argument {
        name,
        value: text.to_string_lossy().into_owned(),
        why: "texts are UTF-8",
    })
}

/// A text in whatever encoding, with replacements for what is no UTF-8. None for NULL.
///
/// # Safety
/// As for [`text`].
pub unsafe fn lossy<'a>(pointer: Text) -> Option<Cow<'a, str>> {
    check(pointer, 1, "").ok()?;
    // SAFETY: not NULL; the caller vouches for the NUL at its end.
    Some(unsafe { CStr::from_ptr(pointer) }.to_string_lossy())
}

fn check<T>(pointer: *const T, n: usize, name: &'static str) -> Outcome<()> {
    if pointer.is_null() {
        return Err(Refusal::Null(name));
    }
    let fits = n
        .checked_mul(size_of::<T>())
        .is_some_and(|size| isize::try_from(size).is_ok());
    if !pointer.is_aligned() || !fits {
        return Err(Refusal::Pointer(name));
    }
    Ok(())
}
