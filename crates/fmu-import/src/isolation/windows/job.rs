//! A job object: processes that end together, with all that they start.
//!
//! Windows closes the handles of a process that ends, however it ends, and a job whose last handle is closed ends its
//! processes. So nothing outlives its supervisor (Windows 8 or newer, where jobs may lie in jobs).

use std::{
    os::windows::io::{AsRawHandle, FromRawHandle, OwnedHandle},
    ptr,
};

use windows_sys::Win32::System::{
    JobObjects::{
        AssignProcessToJobObject, CreateJobObjectW, JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE,
        JOBOBJECT_EXTENDED_LIMIT_INFORMATION, JobObjectExtendedLimitInformation, SetInformationJobObject,
        TerminateJobObject,
    },
    Threading::{PROCESS_SET_QUOTA, PROCESS_TERMINATE},
};

use super::process::{KILLED, open};

/// A group of processes, which end with it.
#[derive(Debug)]
pub struct ControlGroup(OwnedHandle);

impl ControlGroup {
    /// A new group without processes; `None` where the system has no room for it.
    pub fn new() -> Option<Self> {
        // SAFETY: no attributes and no name: a new object that no other process gets.
        let handle = unsafe { CreateJobObjectW(ptr::null(), ptr::null()) };
        if handle.is_null() {
            return None;
        }
        // SAFETY: it was just made, and nobody else owns it.
        let handle = unsafe { OwnedHandle::from_raw_handle(handle) };
        let mut limits = JOBOBJECT_EXTENDED_LIMIT_INFORMATION::default();
        limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
        // SAFETY: a valid handle, and a struct of the kind and size that are named.
        let set = unsafe {
            SetInformationJobObject(
                handle.as_raw_handle(),
                JobObjectExtendedLimitInformation,
                (&raw const limits).cast(),
                size_of_val(&limits) as u32,
            )
        };
        (set != 0).then_some(Self(handle))
    }

    /// Takes a process in, with all that it will start. Whether that was possible.
    pub fn take(&self, pid: u32) -> bool {
        let Some(process) = open(pid, PROCESS_SET_QUOTA | PROCESS_TERMINATE) else {
            return false;
        };
        // SAFETY: two valid handles.
        unsafe { AssignProcessToJobObject(self.0.as_raw_handle(), process.as_raw_handle()) != 0 }
    }

    /// Ends all processes in it at once.
    pub fn end(&self) {
        // SAFETY: a valid handle. Where that fails, there is none left to end.
        unsafe { TerminateJobObject(self.0.as_raw_handle(), KILLED) };
    }
}
