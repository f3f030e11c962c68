//! How workers are started elsewhere: by a command that starts a program on another machine and connects its standard input and
//! output, such as `srun`, `ssh` or `kubectl exec -i`.

use std::{path::PathBuf, process::Command, time::Duration};

/// Where `{host}` stands in the command, it becomes the host's name.
const HOST: &str = "{host}";

/// The command, and how many workers it starts where.
#[derive(Clone, Debug)]
pub struct Launcher {
    words: Vec<String>,
    hosts: Vec<Host>,
    /// The program that is started there.
    pub program: PathBuf,
    /// Whether the FMU is sent there; else it is read from a disk that all share.
    pub ship: bool,
    /// How long a worker may take to start, and be silent.
    pub patience: Duration,
    /// The most memory that a process of the FMU may occupy there, bytes; a fair share of that machine's where none is given.
    pub memory: Option<u64>,
}

/// A machine, or whatever the command starts workers on.
#[derive(Clone, Debug)]
struct Host {
    /// Its name, where it is known before a worker answers.
    name: Option<String>,
    /// How many workers it has.
    slots: usize,
}

impl Launcher {
    /// How long a worker may be silent unless the user says otherwise.
    pub const PATIENCE: Duration = Duration::from_secs(30);

    /// A command that starts so many workers wherever it likes.
    ///
    /// # Errors
    /// What is wrong with the command.
    pub fn new(command: &str, slots: usize) -> Result<Self, String> {
        let words: Vec<String> = shlex::split(command).unwrap_or_default();
        if words.is_empty() {
            return Err(format!("`{command}` is not a command"));
        }
        let program = std::env::current_exe().map_err(|error| format!("this program's own path: {error}"))?;
        Ok(Self {
            words,
            hosts: vec![Host { name: None, slots }],
            program,
            ship: false,
            patience: Self::PATIENCE,
            memory: None,
        })
    }

    /// The same on these hosts: a line a host, with its name and the number of its workers, 1 where none is given.
    ///
    /// # Errors
    /// The line that cannot be understood, and why.
    pub fn on(self, hosts: &str) -> Result<Self, String> {
        if !self.wants_hosts() {
            return Err(format!("the launcher's command says nowhere {HOST}, which becomes the host's name"));
        }
        let mut all = Vec::new();
        for (number, line) in (1..).zip(hosts.lines()) {
            let line = line.split('#').next().unwrap_or_default();
            let mut words = line.split_whitespace();
            let Some(name) = words.next() else { continue };
            let slots = words.next().map_or(Some(1), |word| word.parse().ok());
            let slots = slots.filter(|slots| *slots > 0 && words.next().is_none()).ok_or_else(|| {
                format!("line {number}: `{}` is not a host and its number of workers, such as `node7 16`", line.trim())
            })?;
            let name = Some(name.to_owned());
            all.push(Host { name, slots });
        }
        if all.is_empty() { Err("it names no host".to_owned()) } else { Ok(Self { hosts: all, ..self }) }
    }

    /// Whether the command names a host.
    pub fn wants_hosts(&self) -> bool {
        self.words.iter().any(|word| word.contains(HOST))
    }

    /// How many workers there are to be.
    pub fn slots(&self) -> usize {
        self.hosts.iter().map(|host| host.slots).sum()
    }

    /// The places of all workers: of each host one first, so that few points are spread over many.
    pub(crate) fn places(&self) -> Vec<RemoteAddress> {
        let most = self.hosts.iter().map(|host| host.slots).max().unwrap_or(0);
        (0..most)
            .flat_map(|round| self.hosts.iter().filter(move |host| host.slots > round).map(|host| self.place(host)))
            .collect()
    }

    fn place(&self, host: &Host) -> RemoteAddress {
        let name = host.name.clone();
        let words = self.words.iter().map(|word| match &name {
            Some(name) => word.replace(HOST, name),
            None => word.clone(),
        });
        RemoteAddress { words: words.collect(), name, slots: host.slots }
    }
}

/// Where one worker is started.
#[derive(Debug)]
pub struct RemoteAddress {
    words: Vec<String>,
    /// The host's name, where the user gave it.
    pub name: Option<String>,
    /// How many workers that host has.
    pub slots: usize,
}

impl RemoteAddress {
    /// The command that starts `program` with this argument there.
    pub fn command(&self, launcher: &Launcher, argument: &str) -> Command {
        let mut command = Command::new(&self.words[0]);
        command.args(&self.words[1..]);
        command.arg(&launcher.program).arg(argument);
        command
    }

    /// What a user calls it.
    pub fn label(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => format!("`{}`", self.words.join(" ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(launcher: &Launcher) -> Vec<String> {
        let places = launcher.places().into_iter();
        places.map(|place| place.words.join("|")).collect()
    }

    #[test]
    fn hosts_take_turns() {
        let launcher = Launcher::new("ssh -o 'A B' me@{host}", 3).unwrap();
        assert_eq!(launcher.slots(), 3);
        let launcher = launcher.on("one 2 # comment\n\n  two\n# none\n").unwrap();
        let [one, two] = ["one", "two"].map(|name| format!("ssh|-o|A B|me@{name}"));
        assert_eq!(words(&launcher), [one.clone(), two, one]);
        assert_eq!(launcher.slots(), 3);
    }

    #[test]
    fn what_is_no_list_of_hosts_is_told() {
        let launcher = || Launcher::new("ssh {host}", 1).unwrap();
        for (text, word) in [("a 0", "line 1"), ("a\nb x", "line 2"), ("a 1 2", "line 1"), ("#", "no host")] {
            let error = launcher().on(text).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
        assert!(Launcher::new("ssh node", 1).unwrap().on("a").is_err());
        for command in ["", "  ", "sh 'c"] {
            assert!(Launcher::new(command, 1).is_err(), "{command}");
        }
    }
}
