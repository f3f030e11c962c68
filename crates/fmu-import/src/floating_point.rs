//! How the processor rounds, and which floating-point exceptions it raises: an FMU may change that for itself only.
//!
//! An FMU that rounds upwards from some step on, or one that was compiled with `-ffast-math` and switches subnormal
//! numbers off while it is loaded, would change the importer's own arithmetic: the times of the steps and the
//! statistics. The Rust compiler assumes the usual mode, too. So the usual mode is restored after every call, and the
//! FMU gets its own one back at its next call, as it would have found it in an importer that does nothing about it.

/// The control bits of the processor's floating-point units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Rounding, subnormal numbers and exception masks of vector instructions, without the exceptions that have
    /// occurred.
    vector: u64,
    /// The same of the older unit for 80-bit numbers, where there is one.
    extended: u16,
}

impl Mode {
    /// The mode in which every process starts: rounds to nearest, keeps subnormal numbers, masks exceptions.
    pub const USUAL: Self = if cfg!(target_arch = "x86_64") {
        Self { vector: 0x1f80, extended: 0x037f }
    } else {
        Self { vector: 0, extended: 0 }
    };
}

/// Makes a call of the FMU in its own mode, `theirs`, and keeps there how it leaves that.
///
/// The caller must not be inlined into code with floating-point numbers: the compiler may move such code between the
/// FMU's return and the moment at which the usual mode is restored.
#[inline(always)]
pub fn within<T>(theirs: &mut Mode, call: impl FnOnce() -> T) -> T {
    if *theirs != Mode::USUAL {
        return apart(theirs, call);
    }
    let result = call();
    let now = read();
    if now != Mode::USUAL {
        keep(theirs, now);
    }
    result
}

#[cold]
#[inline(never)]
fn apart<T>(theirs: &mut Mode, call: impl FnOnce() -> T) -> T {
    write(*theirs);
    let result = call();
    keep(theirs, read());
    result
}

#[cold]
#[inline(never)]
fn keep(theirs: &mut Mode, now: Mode) {
    *theirs = now;
    write(Mode::USUAL);
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn read() -> Mode {
    // The exceptions that have occurred.
    const OCCURRED: u32 = 0x3f;
    let (mut vector, mut extended) = (0_u32, 0_u16);
    // SAFETY: both instructions write a control register to a place of its size, and change nothing else.
    unsafe {
        std::arch::asm!(
            "stmxcsr [{vector}]",
            "fnstcw [{extended}]",
            vector = in(reg) &raw mut vector,
            extended = in(reg) &raw mut extended,
            options(nostack, preserves_flags),
        );
    }
    Mode { vector: u64::from(vector & !OCCURRED), extended }
}

#[cfg(target_arch = "x86_64")]
fn write(mode: Mode) {
    // Its upper half is empty.
    let vector = mode.vector as u32;
    let extended = mode.extended;
    // SAFETY: both values were read from the registers, or are those of a new process.
    unsafe {
        std::arch::asm!(
            "ldmxcsr [{vector}]",
            "fldcw [{extended}]",
            vector = in(reg) &raw const vector,
            extended = in(reg) &raw const extended,
            options(nostack, readonly, preserves_flags),
        );
    }
}

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn read() -> Mode {
    let vector: u64;
    // SAFETY: reads the control register; the exceptions that have occurred are in another one.
    unsafe {
        std::arch::asm!("mrs {}, fpcr", out(reg) vector, options(nomem, nostack, preserves_flags));
    }
    Mode { vector, extended: 0 }
}

#[cfg(target_arch = "aarch64")]
fn write(mode: Mode) {
    // SAFETY: the value was read from the register, or is that of a new process.
    unsafe {
        std::arch::asm!("msr fpcr, {}", in(reg) mode.vector, options(nomem, nostack, preserves_flags));
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn read() -> Mode {
    Mode::USUAL
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn write(_: Mode) {}

#[cfg(test)]
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod tests {
    use super::*;
    use std::hint::black_box;

    /// Rounding upwards, in the place where the processor has it.
    fn upwards() -> Mode {
        let mut mode = Mode::USUAL;
        if cfg!(target_arch = "x86_64") {
            mode.vector |= 2 << 13;
            mode.extended |= 2 << 10;
        } else {
            mode.vector |= 1 << 22;
        }
        mode
    }

    #[inline(never)]
    fn third() -> f64 {
        black_box(1.0) / black_box(3.0)
    }

    #[test]
    fn a_mode_lasts_for_the_calls_of_its_owner_only() {
        let nearest = third();
        let mut theirs = Mode::USUAL;
        within(&mut theirs, || write(upwards()));
        assert_eq!(theirs, upwards());
        // Ours is as before, the next call finds the other one, and may leave it again.
        assert_eq!(third().to_bits(), nearest.to_bits());
        let third_of_theirs = within(&mut theirs, third);
        assert!(third_of_theirs > nearest);
        assert_eq!(theirs, upwards());
        within(&mut theirs, || write(Mode::USUAL));
        assert_eq!(theirs, Mode::USUAL);
        assert_eq!(within(&mut theirs, third).to_bits(), nearest.to_bits());
    }

    #[test]
    fn exceptions_that_have_occurred_are_no_mode() {
        let mut theirs = Mode::USUAL;
        assert!(within(&mut theirs, || black_box(1.0) / black_box(0.0)) > 1.0);
        assert_eq!(theirs, Mode::USUAL);
    }
}
