//! Which file uses which, read from the paths in the sources.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::Path;

use syn::visit::{self, Visit};
use syn::{Attribute, Item, UseTree, Visibility};

/// A crate's files with the paths that they use. Tests are left out.
pub struct Tree {
    /// Files by the path of their module.
    modules: HashMap<Vec<String>, String>,
    /// The names that a module hands on, and the paths from which it has them.
    handed_on: HashMap<(Vec<String>, String), Vec<String>>,
    /// Which file uses which, and the name for which it does.
    used: BTreeSet<(String, String, String)>,
}

impl Tree {
    /// Reads the sources in a folder.
    pub fn read(folder: &Path) -> Self {
        let mut tree = Self { modules: HashMap::new(), handed_on: HashMap::new(), used: BTreeSet::new() };
        let mut parsed = Vec::new();
        for file in files(folder, "") {
            let text = fs::read_to_string(folder.join(&file)).unwrap();
            let module = path_of(&file);
            tree.modules.insert(module.clone(), file.clone());
            let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
            parsed.push((file, module, syntax));
        }
        let mut paths = Vec::new();
        for (file, module, syntax) in &parsed {
            let mut reader = Reader {
                module: module.clone(),
                children: tree.children(module),
                paths: Vec::new(),
                handed_on: Vec::new(),
            };
            reader.visit_file(syntax);
            for (name, path) in reader.handed_on {
                tree.handed_on.insert((module.clone(), name), path);
            }
            paths.extend(reader.paths.into_iter().map(|path| (file.clone(), path)));
        }
        for (file, path) in paths {
            if let Some((to, name)) = tree.resolve(&path, 0)
                && to != file
                && !is_part(&path_of(&file), &path_of(&to))
            {
                tree.used.insert((file, to, name));
            }
        }
        tree
    }

    fn children(&self, module: &[String]) -> BTreeSet<String> {
        let below = self.modules.keys().filter(|other| other.len() == module.len() + 1 && other.starts_with(module));
        below.filter_map(|other| other.last().cloned()).collect()
    }

    /// The file in which a path ends, and the name that is used of it.
    fn resolve(&self, path: &[String], depth: usize) -> Option<(String, String)> {
        let length = (0..=path.len()).rev().find(|&n| self.modules.contains_key(&path[..n]))?;
        let (module, rest) = path.split_at(length);
        let name = rest.first().or(module.last())?.clone();
        if let Some(first) = rest.first()
            && let Some(origin) = self.handed_on.get(&(module.to_vec(), first.clone()))
            && depth < 10
        {
            return self.resolve(origin, depth + 1);
        }
        Some((self.modules[module].clone(), name))
    }

    /// The files, as their paths from the folder.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.modules.values().map(String::as_str)
    }

    /// Which file uses which, and the name for which it does.
    pub fn arrows(&self) -> impl Iterator<Item = (&str, &str, &str)> {
        let arrows = self.used.iter();
        arrows.map(|(from, to, name)| (from.as_str(), to.as_str(), name.as_str()))
    }
}

/// Whether a module lies within another one: a part may name what belongs to the whole.
fn is_part(module: &[String], whole: &[String]) -> bool {
    !whole.is_empty() && module.starts_with(whole)
}

/// The top-level module of a file.
pub fn module(file: &str) -> String {
    let first = file.split('/').next().unwrap_or(file);
    first.trim_end_matches(".rs").to_owned()
}

fn files(folder: &Path, prefix: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder.join(prefix)).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}/{name}") };
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(folder, &path));
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") && !path.starts_with("bin/") {
            found.push(path);
        }
    }
    found
}

fn path_of(file: &str) -> Vec<String> {
    let stem = file.trim_end_matches(".rs").trim_end_matches("/mod");
    if stem == "lib" || stem == "mod" {
        return Vec::new();
    }
    stem.split('/').map(str::to_owned).collect()
}

/// Collects the paths of one file, from the root of the crate.
struct Reader {
    module: Vec<String>,
    children: BTreeSet<String>,
    paths: Vec<Vec<String>>,
    handed_on: Vec<(String, Vec<String>)>,
}

impl Reader {
    /// A path from the crate's root; `None` where it leads out of the crate.
    fn absolute(&self, path: &[String]) -> Option<Vec<String>> {
        let mut from = match path.first()?.as_str() {
            "crate" => Vec::new(),
            "self" | "super" => self.module.clone(),
            child if self.children.contains(child) => {
                return Some([&self.module[..], path].concat());
            }
            _ => return None,
        };
        let mut rest = path[..].iter().peekable();
        while let Some(word) = rest.next_if(|word| ["crate", "self", "super"].contains(&word.as_str())) {
            if word == "super" {
                from.pop();
            }
        }
        from.extend(rest.cloned());
        Some(from)
    }

    fn take_use(&mut self, tree: &UseTree, before: &[String], public: bool) {
        match tree {
            UseTree::Path(path) => {
                let path_so_far = [before, &[path.ident.to_string()]].concat();
                self.take_use(&path.tree, &path_so_far, public);
            }
            UseTree::Group(group) => {
                for inner in &group.items {
                    self.take_use(inner, before, public);
                }
            }
            UseTree::Name(name) => self.take_name(before, &name.ident.to_string(), None, public),
            UseTree::Rename(name) => {
                let as_name = name.rename.to_string();
                self.take_name(before, &name.ident.to_string(), Some(as_name), public);
            }
            UseTree::Glob(_) => self.paths.extend(self.absolute(before)),
        }
    }

    fn take_name(&mut self, before: &[String], name: &str, renamed: Option<String>, public: bool) {
        let path = match name {
            "self" => before.to_vec(),
            _ => [before, &[name.to_owned()]].concat(),
        };
        let Some(path) = self.absolute(&path) else {
            return;
        };
        if public {
            let own = renamed.or(path.last().cloned()).unwrap_or_default();
            self.handed_on.push((own, path.clone()));
        }
        self.paths.push(path);
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        match item {
            Item::Use(item) if !for_tests(&item.attrs) => {
                let public = !matches!(item.vis, Visibility::Inherited);
                self.take_use(&item.tree, &[], public);
            }
            Item::Mod(item) if for_tests(&item.attrs) => {}
            Item::Mod(item) => {
                self.module.push(item.ident.to_string());
                visit::visit_item_mod(self, item);
                self.module.pop();
            }
            Item::Fn(item) if for_tests(&item.attrs) => {}
            other => visit::visit_item(self, other),
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let words: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        // A single word was brought here by a `use`.
        if words.len() > 1 {
            self.paths.extend(self.absolute(&words));
        }
        visit::visit_path(self, path);
    }

    /// Paths in the words of a macro, such as those of `format!`.
    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        let text = item.tokens.to_string();
        let words: Vec<&str> = text.split_whitespace().collect();
        for (k, word) in words.iter().enumerate() {
            if !["crate", "self", "super"].contains(word) {
                continue;
            }
            let joined = words[k + 1..].chunks_exact(2);
            let joined = joined.take_while(|pair| pair[0] == "::");
            let is_name = |c: char| c.is_alphanumeric() || c == '_';
            let names = joined.map(|pair| pair[1].trim_end_matches(|c| !is_name(c)).to_owned());
            let path: Vec<String> = std::iter::once((*word).to_owned()).chain(names).collect();
            if path.len() > 1 {
                self.paths.extend(self.absolute(&path));
            }
        }
        visit::visit_macro(self, item);
    }
}

fn for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let list = attribute.meta.require_list();
        attribute.path().is_ident("cfg")
            && list.is_ok_and(|list| {
                let condition = list.tokens.to_string();
                condition == "test" || condition.starts_with("all (test")
            })
    })
}

/// Files that use each other, directly or through others.
pub struct Circle {
    pub files: Vec<String>,
    pub arrows: Vec<String>,
}

/// All circles of a tree.
pub fn circles(tree: &Tree) -> Vec<Circle> {
    let mut next: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (from, to, _) in tree.arrows() {
        next.entry(from).or_default().insert(to);
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> = next.keys().map(|&file| (file, reach(&next, file))).collect();
    let mut circles: Vec<Circle> = Vec::new();
    for (&file, own) in &reached {
        let known = circles.iter().any(|circle| circle.files.iter().any(|other| other == file));
        if known || !own.contains(file) {
            continue;
        }
        let mutual = |other: &&&str| reached.get(**other).is_some_and(|back| back.contains(file));
        let files: Vec<String> = own.iter().filter(mutual).map(|&other| other.to_owned()).collect();
        let inside = |file: &str| files.iter().any(|other| other == file);
        let arrows = tree.arrows().filter(|(from, to, _)| inside(from) && inside(to));
        let arrows = arrows.map(|(from, to, name)| format!("{from} uses {name} of {to}"));
        circles.push(Circle { arrows: arrows.collect(), files });
    }
    circles
}

fn reach<'a>(next: &BTreeMap<&'a str, BTreeSet<&'a str>>, from: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&str> = vec![from];
    while let Some(file) = open.pop() {
        for &other in next.get(file).into_iter().flatten() {
            if reached.insert(other) {
                open.push(other);
            }
        }
    }
    reached
}
