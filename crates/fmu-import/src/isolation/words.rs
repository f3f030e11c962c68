//! Keeps the last lines that children print.

use std::{
    fs::File,
    io::{self, Read, Write},
    os::fd::{AsFd, BorrowedFd},
};

use rustix::{
    io::ioctl_fionbio,
    stdio::{dup2_stderr, dup2_stdout},
};

use super::{
    system::pipe,
    tail::{KEPT, Tail, harmless},
};

/// Hears what this process and its children print.
#[derive(Debug)]
pub struct Words {
    heard: File,
    end: Tail,
    echo: Option<File>,
}

impl Words {
    /// Takes over standard output and standard error of this process and of its later children;
    /// with `echo`, what is printed is repeated there.
    ///
    /// # Errors
    /// When the system has no room for further descriptors.
    pub fn overhear(echo: Option<File>) -> io::Result<Self> {
        let (heard, printed) = pipe()?;
        dup2_stdout(&printed)?;
        dup2_stderr(&printed)?;
        ioctl_fionbio(&heard, true)?;
        Ok(Self { heard: heard.into(), end: Tail::default(), echo })
    }

    /// Reads what has been printed so far.
    pub fn hear(&mut self) {
        let mut chunk = [0; KEPT];
        // At most what a pipe holds: a child that prints without an end must not keep us here.
        for _ in 0..16 {
            let Ok(count @ 1..) = self.heard.read(&mut chunk) else { return };
            if let Some(echo) = &mut self.echo {
                // Nobody may be listening.
                let _ = echo.write_all(harmless(&chunk[..count]).as_bytes());
            }
            self.end.add(&chunk[..count]);
        }
    }

    /// Forgets what has been printed so far.
    pub fn clear(&mut self) {
        self.hear();
        self.end = Tail::default();
    }

    /// The printed text that was kept.
    pub fn text(&mut self) -> String {
        self.hear();
        self.end.text()
    }

    /// The last line that is not empty.
    pub fn last_line(&mut self) -> String {
        self.hear();
        self.end.last_line()
    }
}

impl AsFd for Words {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.heard.as_fd()
    }
}
