//! Receives the messages of an FMU.
//!
//! An FMU may call its logger with any environment, from any thread, even after `fmi2FreeInstance`. So the
//! environment is no pointer but a ticket, which is looked up, and what an FMU knows by address is never freed:
//! each instance takes a seat, and seats of instances that have gone are taken again.

use std::{
    borrow::Cow,
    collections::VecDeque,
    ffi::{CStr, c_char, c_int, c_void},
    panic::catch_unwind,
    ptr,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use crate::{call::Warnings, validity};

/// Messages kept; the oldest go first, so that a chatty FMU costs no memory.
const KEPT: usize = 32;

/// The ticket of the first seat: unlike the small numbers that some FMUs pass as their environment.
const FIRST: usize = 0x6d75_0001;

const WARNING: i32 = 1;

/// How many seats stay empty before one is taken again, so that a late message finds nobody rather than the next.
const RESTING: usize = 32;

/// The struct `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Debug)]
pub struct Callbacks {
    pub logger: unsafe extern "C" fn(),
    pub allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    pub environment: *const c_void,
}

/// The place at which an instance's messages arrive. It is never freed.
#[derive(Debug)]
struct Seat {
    callbacks: Callbacks,
    taken: AtomicBool,
    heard: Mutex<Heard>,
}

// SAFETY: the callbacks are written before the seat is shared, and read only from then on; their environment is a
// number that nobody dereferences.
unsafe impl Send for Seat {}
// SAFETY: as above; all else in a seat is made to be shared.
unsafe impl Sync for Seat {}

#[derive(Debug, Default)]
struct Heard {
    messages: VecDeque<(i32, String)>,
    warnings: Warnings,
    /// How many warnings there were when a call last returned one: those in between are that call's.
    returned: u64,
    /// Whether the first warning is that of a call.
    is_named: bool,
    strays: u64,
}

/// All seats, in the order of their tickets, and those that are free.
#[derive(Debug)]
struct Seats {
    all: Vec<&'static Seat>,
    free: VecDeque<usize>,
}

static SEATS: Mutex<Seats> = Mutex::new(Seats { all: Vec::new(), free: VecDeque::new() });

/// Takes a lock even after a thread panicked while it held it: no update of the protected data can be left half done.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Seat {
    fn new(number: usize) -> Self {
        Self {
            callbacks: Callbacks {
                logger: fmu_import_logger,
                allocate_memory: libc::calloc,
                free_memory: libc::free,
                // A step that is pending is asked for its status. With a function here, FMUs of Dymola warn that they
                // take no asynchronous steps.
                step_finished: None,
                environment: ptr::without_provenance(FIRST + number),
            },
            taken: AtomicBool::new(true),
            heard: Mutex::default(),
        }
    }

    fn hear(&self, status: i32, message: String, stray: bool, of_validity: bool) {
        let mut heard = locked(&self.heard);
        heard.strays += u64::from(stray);
        if of_validity {
            let beyond = &mut heard.warnings.beyond;
            if validity::is_further(&message, beyond.iter().map(String::as_str)) {
                beyond.push(message.clone());
            }
            // It is no reason of what fails later.
            if status == 0 {
                return;
            }
        }
        if status == WARNING {
            heard.warnings.count += 1;
            heard.warnings.first.get_or_insert_with(|| message.clone());
        }
        if heard.messages.len() == KEPT {
            heard.messages.pop_front();
        }
        heard.messages.push_back((status, message));
    }
}

/// The last messages of one instance.
#[derive(Debug)]
pub struct Log {
    number: usize,
    seat: &'static Seat,
}

impl Log {
    /// Takes a seat.
    pub fn open() -> Self {
        let mut seats = locked(&SEATS);
        if seats.free.len() > RESTING
            && let Some(number) = seats.free.pop_front()
        {
            let seat = seats.all[number];
            *locked(&seat.heard) = Heard::default();
            seat.taken.store(true, Ordering::Release);
            return Self { number, seat };
        }
        let number = seats.all.len();
        let seat: &'static Seat = Box::leak(Box::new(Seat::new(number)));
        seats.all.push(seat);
        Self { number, seat }
    }

    /// The struct for `fmi2Instantiate`. It stays valid for ever: some FMUs use it after they were freed.
    pub fn callbacks(&self) -> *const Callbacks {
        &raw const self.seat.callbacks
    }

    /// The environment for FMI 3.0, which passes it beside the callback.
    pub fn environment(&self) -> *const c_void {
        self.seat.callbacks.environment
    }

    /// Forgets all messages.
    pub fn clear(&self) {
        locked(&self.seat.heard).messages.clear();
        self.forget_warnings();
    }

    /// The warnings of messages and calls.
    pub fn warnings(&self) -> Warnings {
        locked(&self.seat.heard).warnings.clone()
    }

    /// Counts warnings from zero again; the messages stay.
    pub fn forget_warnings(&self) {
        let mut heard = locked(&self.seat.heard);
        (heard.warnings, heard.returned) = (Warnings::default(), 0);
        heard.is_named = false;
    }

    /// Counts a call that returned a warning, unless it has logged one.
    #[cold]
    pub fn returned_warning(&self, function: &str) {
        let last = self.last();
        let mut heard = locked(&self.seat.heard);
        heard.warnings.count += u64::from(heard.warnings.count == heard.returned);
        heard.returned = heard.warnings.count;
        if !heard.is_named {
            heard.is_named = true;
            heard.warnings.first = Some(match last {
                Some(message) => format!("{function}: {message}"),
                None => function.to_owned(),
            });
        }
    }

    /// The last message of an error, or else the last message at all.
    pub fn last(&self) -> Option<String> {
        let heard = locked(&self.seat.heard);
        let mut newest_first = heard.messages.iter().rev();
        newest_first
            .find(|(status, _)| matches!(status, 3 | 4))
            .or_else(|| heard.messages.back())
            .map(|(_, message)| message.clone())
    }

    /// How many messages came with an environment that nobody gave to the FMU.
    pub fn strays(&self) -> u64 {
        locked(&self.seat.heard).strays
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        self.seat.taken.store(false, Ordering::Release);
        locked(&SEATS).free.push_back(self.number);
    }
}

/// The seat of a ticket, and whether the ticket is foreign. A message with a foreign ticket goes to the only instance, if
/// there is only one.
fn seat_of(ticket: usize) -> Option<(&'static Seat, bool)> {
    let seats = locked(&SEATS);
    let taken = |seat: &&'static Seat| seat.taken.load(Ordering::Acquire);
    match ticket.checked_sub(FIRST).and_then(|n| seats.all.get(n)) {
        Some(seat) => Some((*seat, false)).filter(|(seat, _)| taken(seat)),
        None => {
            let mut live = seats.all.iter().copied().filter(taken);
            let only = live.next()?;
            live.next().is_none().then_some((only, true))
        }
    }
}

unsafe extern "C" {
    /// The C-variadic callback of `logger.c`; only its address is used here.
    pub fn fmu_import_logger();
}

/// Takes a formatted message: from `logger.c`, or as the callback of FMI 3.0. The strings are zero-terminated or NULL.
#[unsafe(no_mangle)]
pub extern "C" fn fmu_import_log(
    environment: *const c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    if message.is_null() {
        return;
    }
    // A panic must not cross the C frames of the FMU.
    let _ = catch_unwind(|| {
        let category = match category.is_null() {
            true => Cow::Borrowed(""),
            // SAFETY: an FMU passes the category as a zero-terminated string.
            false => unsafe { CStr::from_ptr(category) }.to_string_lossy(),
        };
        // Some FMUs pass every message as "OK"; then the category tells errors and warnings apart.
        let status = if category.contains("Error") || category.contains("Fatal") {
            status.max(3)
        } else if category.contains("Warning") {
            status.max(WARNING)
        } else if category.contains("Discard") {
            status.max(WARNING + 1)
        } else {
            status
        };
        // The address is a number to look up; it is never followed.
        let Some((seat, stray)) = seat_of(environment.addr()) else { return };
        // SAFETY: `logger.c` passes its own zero-terminated buffer, and FMI 3.0 a zero-terminated string.
        let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
        let words: Vec<&str> = message.split_whitespace().collect();
        let of_validity = category == validity::CATEGORY;
        seat.hear(status, shortened(words.join(" ")), stray, of_validity);
    });
}

/// A text of an FMU with its middle left out where it is long: every point of a study may have one.
pub fn shortened(text: String) -> String {
    const HEAD: usize = 200;
    const TAIL: usize = 80;
    let characters = text.chars().count();
    if characters <= HEAD + TAIL + 20 {
        return text;
    }
    let place = |count| text.char_indices().nth(count).map_or(text.len(), |(at, _)| at);
    let [head, tail] = [&text[..place(HEAD)], &text[place(characters - TAIL)..]];
    let left_out = characters - HEAD - TAIL;
    format!("{head} [{left_out} characters left out] {tail}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_text_both_ends_are_kept() {
        let text = format!("begun {} at last", "é".repeat(10_000));
        let short = shortened(text);
        assert!(short.starts_with("begun éé") && short.ends_with("éé at last"));
        assert!(short.contains("é [9734 characters left out] é"), "{short}");
        assert_eq!(shortened("é".repeat(300)), "é".repeat(300));
    }

    fn say(environment: *const c_void, status: c_int, text: &CStr) {
        fmu_import_log(environment, status, ptr::null(), text.as_ptr());
    }

    /// One test, as the seats are those of the whole process.
    #[test]
    fn messages_find_their_instance_and_nothing_else() {
        let [one, other] = [Log::open(), Log::open()];
        let ticket_of = |log: &Log| log.seat.callbacks.environment;
        say(ticket_of(&one), 3, c"of\n one");
        assert_eq!(one.warnings(), Warnings::default());
        say(ticket_of(&other), 77, c"of the other");
        assert_eq!(one.last().as_deref(), Some("of one"));
        assert_eq!(other.last().as_deref(), Some("of the other"));
        // With two instances alive, an unknown ticket cannot be attributed.
        for foreign in [0, 1, 2, usize::MAX] {
            say(ptr::without_provenance(foreign), 3, c"lost");
        }
        assert_eq!((one.strays(), other.strays()), (0, 0));
        let late = ticket_of(&other);
        drop(other);
        say(late, 3, c"too late");
        // Another takes a seat of its own, not the one just left.
        let next = Log::open();
        assert_ne!(ticket_of(&next), late);
        assert_eq!(next.last(), None);
        drop(next);
        say(ptr::without_provenance(1), 1, c"astray");
        assert_eq!(one.strays(), 1);
        let category = c"logStatusWarning".as_ptr();
        fmu_import_log(ticket_of(&one), 0, category, c"by category".as_ptr());
        let warnings = one.warnings();
        assert_eq!((warnings.count, warnings.first.as_deref()), (2, Some("astray")));
        one.forget_warnings();
        assert_eq!(one.warnings(), Warnings::default());
        // `last` stays at the last error, whatever is logged after it. A status that the standard does not know is no error.
        say(ticket_of(&one), -5, c"wild");
        assert_eq!(one.last().as_deref(), Some("of one"));
        fmu_import_log(ticket_of(&one), 0, ptr::null(), ptr::null());
        std::thread::scope(|scope| {
            let environment = ticket_of(&one).addr();
            for _ in 0..4 {
                scope.spawn(move || {
                    for _ in 0..1000 {
                        say(ptr::without_provenance(environment), 1, c"chatter");
                    }
                });
            }
        });
        assert_eq!(locked(&one.seat.heard).messages.len(), KEPT);
        // Seats are taken again in the end, so that many instances take no more memory than few.
        let before = locked(&SEATS).all.len();
        (0..10 * RESTING).for_each(|_| drop(Log::open()));
        assert!(locked(&SEATS).all.len() <= before + RESTING + 1);
    }
}
