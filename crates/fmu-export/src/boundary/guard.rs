//! The checks that every call passes before it reaches an instance: the handle is ours, no other call is at work in the
//! instance, and the state machine allows the function. A panic in the call stops here.

use std::{
    any::Any,
    cell::UnsafeCell,
    ffi::c_void,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
};

use super::{
    describe::hash,
    description::{Interface, fingerprint},
    instance::{Instance, check_host},
    logger::Logger,
    phase::{Function, Phase, of},
    raw::lossy,
    refusal::{Outcome, Refusal},
    types::{Component, Status, Text},
    version::Version,
    watch::Watch,
};
use crate::model::Model;

/// The number at the start of every object that the host holds a handle of. It differs between kinds of object, between
/// models, between versions of the standard, and between loaded libraries, so that a handle of another FMU is not taken
/// for one of ours.
#[inline]
pub fn magic<M: Model>(kind: u64, version: Version) -> u64 {
    static ANCHOR: u8 = 0;
    // Every call comes through here, so all but the address, which differs between libraries, is known at compile time.
    let library = (&raw const ANCHOR).addr() as u64;
    library ^ const { hash(M::INFO.identifier) as u64 } ^ kind ^ ((version as u64) << 32)
}

/// The target of the pointer that the host has of an instance.
#[repr(C)]
pub struct Handle<M> {
    magic: AtomicU64,
    busy: AtomicBool,
    instance: UnsafeCell<Instance<M>>,
}

impl<M: Model> Handle<M> {
    const KIND: u64 = 0x1257_a1ce;

    /// Hands an instance over to the host.
    pub fn give(instance: Instance<M>) -> Component {
        Box::into_raw(Box::new(Self {
            magic: AtomicU64::new(magic::<M>(Self::KIND, instance.version)),
            busy: AtomicBool::new(false),
            instance: UnsafeCell::new(instance),
        }))
        .cast()
    }

    /// Frees an instance. NULL, foreign and busy handles are left alone.
    ///
    /// # Safety
    /// The component is NULL, or points to at least eight readable bytes; one of ours is given
    /// back only once, while no other thread uses it.
    pub unsafe fn end(component: Component, version: Version) {
        // SAFETY: the caller promises what `find` asks for: NULL or eight readable bytes, and no freed handle of ours.
        let Some(handle) = (unsafe { Self::find(component, version) }) else { return };
        if handle.busy.swap(true, Ordering::Acquire) {
            return;
        }
        // SAFETY: the busy flag was clear, so this is the only reference.
        if unsafe { &*handle.instance.get() }.run.phase == Phase::Intermediate {
            // The host's callback tries to free the instance whose step has called it.
            handle.busy.store(false, Ordering::Release);
            return;
        }
        handle.magic.store(0, Ordering::Relaxed);
        // SAFETY: made by `give`, and no longer found by anyone else.
        let handle = unsafe { Box::from_raw(component.cast::<Self>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
    }

    /// # Safety
    /// The component is NULL, or points to at least eight readable bytes; one of ours is alive.
    unsafe fn find<'a>(component: Component, version: Version) -> Option<&'a Self> {
        // SAFETY: as the caller promises; the number is written by `give` only, in front of a handle of this type.
        unsafe { ours(component, magic::<M>(Self::KIND, version), "component") }.ok()
    }
}

/// What a pointer that the host has points to, if that begins with the number of its kind of objects.
///
/// # Safety
/// The pointer is NULL, or points to at least eight readable bytes; this number stands only in front of a living `T`.
pub unsafe fn ours<'a, T>(pointer: *mut c_void, magic: u64, name: &'static str) -> Outcome<&'a T> {
    let first = pointer.cast::<AtomicU64>();
    if first.is_null() {
        return Err(Refusal::Null(name));
    }
    if !first.is_aligned() {
        return Err(Refusal::Misaligned(name));
    }
    // SAFETY: not NULL, aligned, readable.
    if unsafe { &*first }.load(Ordering::Relaxed) != magic {
        return Err(Refusal::Foreign(name));
    }
    // SAFETY: the caller promises that such an object has this number.
    Ok(unsafe { &*pointer.cast::<T>() })
}

/// What is known of an instance that a host asks for.
pub struct InstanceRequest<M> {
    /// A hash of the description.
    pub fingerprint: u128,
    /// How the host looks into communication steps.
    pub watch: Option<Watch<M>>,
    /// Whether it uses the event mode of Co-Simulation, and whether steps may end early then.
    pub event_mode: Option<bool>,
}

impl<M: Model> InstanceRequest<M> {
    /// That of this description, for a host that wants no more.
    pub fn of(version: Version, interface: Interface) -> Self {
        Self { fingerprint: fingerprint::<M>(version, interface), watch: None, event_mode: None }
    }
}

/// Makes an instance for a host that names it, its token and its resources: with the `logger` for its name, if `check` lets it. NULL if it is refused.
///
/// # Safety
/// The texts are NULL or end with NUL.
pub unsafe fn instantiate_by<M: Model>(
    function: &'static str,
    (version, exchange): (Version, bool),
    texts: [Text; 3],
    logger: impl FnOnce(&str) -> Option<Logger>,
    check: impl FnOnce() -> Outcome<InstanceRequest<M>>,
) -> Component {
    let make = || {
        // SAFETY: as the caller promises. Some hosts write names and paths in their system's code page, not in UTF-8.
        let [name, token, resources] = texts.map(|text| unsafe { lossy(text) });
        let name = name.as_deref().unwrap_or_default();
        let logger = logger(name)?;
        let known = check()
            .and_then(|known| {
                check_host(version, name, &token.unwrap_or_default(), known.fingerprint)?;
                Ok(known)
            })
            .map_err(|refusal| logger.refuse(function, &refusal))
            .ok()?;
        let (form, resources) = ((version, exchange), resources.as_deref());
        let mut instance = Instance::new(function, form, known.fingerprint, resources, logger);
        (instance.watch, instance.event_mode) = (known.watch, known.event_mode);
        Some(Handle::give(instance))
    };
    catch_unwind(AssertUnwindSafe(make)).ok().flatten().unwrap_or(std::ptr::null_mut())
}

/// Resets the busy flag when the call ends, even by a panic.
struct BusyCall<'a>(&'a AtomicBool);

impl Drop for BusyCall<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Runs `body` on the instance behind a component, if `function` may be called now.
///
/// # Safety
/// As for [`Handle::end`], but that the component is not given back.
pub unsafe fn enter<M: Model>(
    component: Component,
    function: &Function,
    body: impl FnOnce(&mut Instance<M>) -> Outcome,
) -> Status {
    // SAFETY: the caller promises what `find` asks for: NULL or eight readable bytes, and no freed handle of ours.
    let Some(handle) = (unsafe { Handle::<M>::find(component, function.version) }) else { return Status::Error };
    if handle.busy.swap(true, Ordering::Acquire) {
        // A call from a second thread, or from within the logger.
        return Status::Error;
    }
    let _busy = BusyCall(&handle.busy);
    // SAFETY: the busy flag was clear, so this is the only reference.
    let instance = unsafe { &mut *handle.instance.get() };
    match catch_unwind(AssertUnwindSafe(|| checked(instance, function, body))) {
        Ok(status) => status,
        Err(panic) => poison(instance, function, panic.as_ref()),
    }
}

fn checked<M: Model>(
    instance: &mut Instance<M>,
    function: &Function,
    body: impl FnOnce(&mut Instance<M>) -> Outcome,
) -> Status {
    let phase = instance.run.phase;
    if phase == Phase::Fatal {
        return Status::Fatal;
    }
    let outcome = if function.phases & of(&[phase]) != 0 { body(instance) } else { Err(Refusal::Phase(phase)) };
    match outcome {
        Ok(()) => Status::Ok,
        Err(refusal) => {
            instance.logger.refuse(function.name, &refusal);
            refusal.status()
        }
    }
}

fn poison<M: Model>(instance: &mut Instance<M>, function: &Function, panic: &(dyn Any + Send)) -> Status {
    let text = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    instance.run.phase = Phase::Fatal;
    let message = format!(
        "{}: internal error: {text}. The instance is unusable now: free it, and please report this.",
        function.name
    );
    instance.logger.send(Status::Fatal, "logStatusFatal", &message);
    Status::Fatal
}
