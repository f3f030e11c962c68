//! Start of a child: a program of its own, which takes its [`ChildEnd`] from its standard streams.

use std::{
    fs::File,
    io,
    os::windows::io::{AsHandle, AsRawHandle, OwnedHandle},
    process::{Command, Stdio},
};

use windows_sys::Win32::System::Console::{STD_INPUT_HANDLE, STD_OUTPUT_HANDLE, SetStdHandle};

use super::{
    job::ControlGroup,
    keeper::{Keeper, Process},
    pipe::Arrivals,
    process,
};
use crate::isolation::{
    child::Child,
    frame::{self, Inbox},
    loss::MUTE,
};

impl Keeper {
    /// Starts a program as a child: it has to begin with [`ChildEnd::take`].
    ///
    /// # Errors
    /// When the system has no room for a further process.
    pub fn start(&mut self, command: &mut Command) -> io::Result<Child> {
        // Odd, so that every ticket of the 2^64 has its turn.
        self.tickets = self.tickets.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let ticket = self.tickets;
        let mut process =
            process::detach(command).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        // It waits for its ticket, so whatever it starts will be in the job.
        let group = ControlGroup::new().filter(|group| group.take(process.id()));
        let missing = || io::Error::other("a pipe to the process is missing");
        let mut orders = process.stdin.take().ok_or_else(missing)?;
        let answers = process.stdout.take().ok_or_else(missing)?;
        self.words.listen(process.stderr.take().ok_or_else(missing)?);
        frame::write(&mut orders, 0, &ticket.to_le_bytes())?;
        let process = Process { process, group };
        Ok(Child::new(process, Arrivals::of(answers), orders, ticket))
    }
}

/// A child's own end of the pipes to its keeper.
#[derive(Debug)]
pub struct ChildEnd {
    ticket: u64,
    orders: Inbox<File>,
    answers: File,
}

impl ChildEnd {
    /// Takes standard input and output for the keeper alone: reading gives the FMU nothing, and what it prints goes to
    /// standard error, where the keeper hears it.
    ///
    /// # Errors
    /// When there is no keeper.
    pub fn take() -> io::Result<Self> {
        process::end_without_words();
        let [orders, answers] = own_streams()?;
        let mut orders = Inbox::new(orders, 0);
        let missing = || io::Error::other("no keeper has started this process");
        let ticket = orders.wait()?.ok_or_else(missing)?;
        let ticket = u64::from_le_bytes(ticket.try_into().map_err(|_| missing())?);
        orders.expect(ticket);
        Ok(Self { ticket, orders, answers })
    }

    /// Sends an answer. A child that cannot send ends here.
    pub fn send(&mut self, payload: &[u8]) {
        if frame::write(&self.answers, self.ticket, payload).is_err() {
            process::end(MUTE);
        }
    }

    /// Waits for the keeper's next message; `None` when none will come.
    pub fn receive(&mut self) -> Option<Vec<u8>> {
        self.orders.wait().ok().flatten()
    }
}

/// The handles of standard input and output, which the FMU does not find any more.
fn own_streams() -> io::Result<[File; 2]> {
    let input = io::stdin().as_handle().try_clone_to_owned()?;
    let output = io::stdout().as_handle().try_clone_to_owned()?;
    let nothing = OwnedHandle::from(File::open("NUL")?);
    let error = io::stderr().as_handle().try_clone_to_owned()?;
    // SAFETY: valid handles, which stay open for as long as this process lives. The C runtime has handles of its own,
    // of which the first two are closed and replaced.
    unsafe {
        libc::dup2(2, 1);
        libc::close(0);
        SetStdHandle(STD_INPUT_HANDLE, nothing.as_raw_handle());
        SetStdHandle(STD_OUTPUT_HANDLE, error.as_raw_handle());
    }
    std::mem::forget([nothing, error]);
    Ok([input, output].map(File::from))
}
