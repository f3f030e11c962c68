//! Notices when anything changes in a folder.
//!
//! All points of a study see the folder of the unpacked FMU, so what one of them writes there another may read.
//! On Linux the kernel queues an event before the writing call returns (`inotify(7)`): whoever looks after a point
//! has ended misses nothing, and where nothing was written that costs one system call. On other systems names,
//! sizes and times are compared.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::archive::entries_in;

/// The files and folders below a folder, each with its size and times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot(BTreeMap<PathBuf, State>);

/// Size, time of the last change of the content, and of the entry itself: s and ns each.
type State = (u64, [i64; 4]);

#[cfg(unix)]
fn times(entry: &fs::Metadata) -> [i64; 4] {
    use std::os::unix::fs::MetadataExt;
    [entry.mtime(), entry.mtime_nsec(), entry.ctime(), entry.ctime_nsec()]
}

/// Windows keeps no time of the last change of an entry; its other times count 100 ns.
#[cfg(windows)]
fn times(entry: &fs::Metadata) -> [i64; 4] {
    use std::os::windows::fs::MetadataExt;
    let [changed, made] = [entry.last_write_time(), entry.creation_time()].map(u64::cast_signed);
    [changed, made, i64::from(entry.file_attributes()), 0]
}

impl Snapshot {
    /// The folder as it is now. What cannot be read is left out, so it differs from what could be.
    pub fn of(folder: &Path) -> Self {
        let mut all = BTreeMap::new();
        let mut open = vec![folder.to_owned()];
        while let Some(path) = open.pop() {
            let Ok(entry) = fs::symlink_metadata(&path) else { continue };
            if entry.is_dir() {
                open.extend(entries_in(&path).map(|entry| entry.path()));
            }
            // The size of a folder says nothing more.
            let size = if entry.is_dir() { 0 } else { entry.len() };
            all.insert(path, (size, times(&entry)));
        }
        Self(all)
    }

    /// The first file that another snapshot has otherwise, or a folder where no file differs.
    pub fn difference(&self, other: &Self) -> Option<PathBuf> {
        let missing = |one: &Self, two: &Self| one.0.keys().filter(|path| !two.0.contains_key(*path)).min().cloned();
        let changed = |(path, state): (&PathBuf, &State)| {
            let then = other.0.get(path).filter(|then| *then != state)?;
            // A folder changes with each entry that comes or goes, and then the entry tells more.
            Some((then.0 == 0 && state.0 == 0, path.clone()))
        };
        missing(other, self)
            .or_else(|| missing(self, other))
            .or_else(|| Some(self.0.iter().filter_map(changed).min()?.1))
    }
}

/// Watches a folder with all that is in it.
#[derive(Debug)]
pub struct Watch {
    folder: PathBuf,
    before: Snapshot,
    events: Option<Events>,
    changed: Option<PathBuf>,
}

impl Watch {
    /// Watches a folder from now on.
    pub fn on(folder: &Path) -> Self {
        // In this order: a change in between is seen twice rather than not at all.
        let events = Events::of(&Snapshot::of(folder));
        Self { folder: folder.to_owned(), before: Snapshot::of(folder), events, changed: None }
    }

    /// The first thing that was found changed since the beginning, as a path within the folder; empty where it is
    /// the folder itself, or something that is gone again.
    pub fn changed(&mut self) -> Option<&Path> {
        if self.changed.is_none() {
            self.changed = self.look();
        }
        self.changed.as_deref()
    }

    fn look(&self) -> Option<PathBuf> {
        let seen = match &self.events {
            Some(events) => events.read(),
            // Without events, compare the files themselves.
            None => FileNews::Opened,
        };
        if seen == FileNews::Nothing {
            return None;
        }
        let place = self.before.difference(&Snapshot::of(&self.folder));
        match (place.map(|place| place.strip_prefix(&self.folder).map(Path::to_owned).unwrap_or_default()), seen) {
            (None, FileNews::Changed) => Some(PathBuf::new()),
            (place, _) => place,
        }
    }
}

/// The news in events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum FileNews {
    Nothing,
    /// A file was open for writing, which tells nothing yet: Fortran opens so what it only reads. What is written
    /// to a file mapped into memory shows in no other event.
    Opened,
    /// Only events tell so.
    #[cfg_attr(not(target_os = "linux"), allow(dead_code))]
    Changed,
}

#[cfg(target_os = "linux")]
use linux::Events;

#[cfg(not(target_os = "linux"))]
#[derive(Debug)]
struct Events;

#[cfg(not(target_os = "linux"))]
impl Events {
    fn of(_: &Snapshot) -> Option<Self> {
        None
    }

    fn read(&self) -> FileNews {
        FileNews::Opened
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::{mem::MaybeUninit, os::fd::OwnedFd};

    use rustix::{
        fs::inotify::{self, CreateFlags, ReadFlags, Reader, WatchFlags},
        io::Errno,
    };

    use super::{FileNews, Snapshot};

    /// The kernel's queue of events.
    #[derive(Debug)]
    pub struct Events(OwnedFd);

    impl Events {
        /// The events of all that is in a snapshot, of files, too, since a link from elsewhere leads to a file alone; `None` where the
        /// system has no room for them.
        pub fn of(snapshot: &Snapshot) -> Option<Self> {
            let wanted = WatchFlags::MODIFY
                | WatchFlags::ATTRIB
                | WatchFlags::CREATE
                | WatchFlags::DELETE
                | WatchFlags::DELETE_SELF
                | WatchFlags::MOVE
                | WatchFlags::MOVE_SELF
                | WatchFlags::CLOSE_WRITE
                | WatchFlags::DONT_FOLLOW;
            let queue = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).ok()?;
            for path in snapshot.0.keys() {
                inotify::add_watch(&queue, path, wanted).ok()?;
            }
            Some(Self(queue))
        }

        /// The gravest of the events so far, which are taken from the queue up to a change.
        pub fn read(&self) -> FileNews {
            let mut seen = FileNews::Nothing;
            let mut buffer = [MaybeUninit::uninit(); 4096];
            let mut events = Reader::new(&self.0, &mut buffer);
            loop {
                match events.next().map(|event| event.events()) {
                    Ok(ReadFlags::CLOSE_WRITE) => seen = FileNews::Opened,
                    Err(Errno::INTR) => {}
                    Err(Errno::AGAIN) => return seen,
                    // A queue that cannot be read may hide anything.
                    _ => return FileNews::Changed,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("resources")).unwrap();
        fs::write(folder.path().join("resources/data.txt"), "1").unwrap();
        folder
    }

    /// The answer of a watch after `act` was done below the folder.
    fn told(act: impl Fn(&Path)) -> Option<PathBuf> {
        let folder = folder();
        let mut watch = Watch::on(folder.path());
        assert_eq!(watch.changed(), None);
        act(folder.path());
        let told = watch.changed().map(Path::to_owned);
        // What was seen once stays so.
        assert_eq!(watch.changed().map(Path::to_owned), told);
        told
    }

    #[test]
    fn reading_is_no_change() {
        let read = |folder: &Path| {
            fs::read(folder.join("resources/data.txt")).unwrap();
            fs::read_dir(folder).unwrap().for_each(drop);
            let data = folder.join("resources/data.txt");
            let both = File::options().read(true).write(true).open(data);
            drop(both.unwrap());
        };
        assert_eq!(told(read), None);
    }

    #[test]
    fn each_change_is_seen_with_its_place() {
        let place = |act: &dyn Fn(&Path)| told(act).map(|path| path.display().to_string());
        let data = "resources/data.txt";
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(place(&|f| fs::write(f.join(data), "2").unwrap()), some(data));
        assert_eq!(place(&|f| fs::remove_file(f.join(data)).unwrap()), some(data));
        assert_eq!(place(&|f| fs::write(f.join("log"), "").unwrap()), some("log"));
        assert_eq!(place(&|f| fs::create_dir(f.join("new")).unwrap()), some("new"));
        let all = |f: &Path| fs::remove_dir_all(f.join("resources")).unwrap();
        assert_eq!(place(&all), some("resources"));
        let back = |f: &Path| {
            fs::write(f.join("resources/state"), "7").unwrap();
            fs::remove_file(f.join("resources/state")).unwrap();
        };
        assert!(told(back).is_some());
    }

    #[test]
    fn a_change_through_a_link_from_elsewhere_is_seen() {
        let elsewhere = folder();
        let link = elsewhere.path().join("link");
        let act = |folder: &Path| {
            fs::hard_link(folder.join("resources/data.txt"), &link).unwrap();
            fs::write(&link, "2").unwrap();
        };
        assert_eq!(told(act).as_deref(), Some(Path::new("resources/data.txt")));
    }

    #[test]
    fn without_events_the_files_are_compared() {
        let folder = folder();
        let mut watch = Watch::on(folder.path());
        watch.events = None;
        assert_eq!(watch.changed(), None);
        fs::write(folder.path().join("resources/data.txt"), "more").unwrap();
        assert_eq!(watch.changed(), Some(Path::new("resources/data.txt")));
    }
}
