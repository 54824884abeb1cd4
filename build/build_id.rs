//! The build id: one number for all builds of simrun that give the same rows.
//!
//! In it is what decides bytes: the sources of the engine, the crates that it is linked with and their features, the compiler, the architecture, and
//! simrun's own features. Out of it is what does not: optimisation, debug information, the model of the processor, and the rooms that start
//! runs and show rows. So a debug build goes on with what a release build has begun, and a better report makes no run another one.
//!
//! The build script computes it, and the tests once more.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::Path;

/// What of `src/` is no engine: the root, which only lists rooms, and rooms that no room of the engine may name (`tests/it/layering.rs`).
pub const SHELL: [&str; 6] = ["cli", "comparison", "lib.rs", "main.rs", "paper", "report"];

/// What a build is made with, apart from its files.
#[derive(Clone, Debug)]
pub struct Tools {
    /// What `rustc --version` says.
    pub compiler: String,
    /// Architecture of the processor, such as `x86_64`.
    pub architecture: String,
    /// Features of simrun that are switched on.
    pub features: BTreeSet<String>,
}

/// The build id of the package in `folder`.
///
/// # Errors
/// If its sources or its `Cargo.toml` cannot be read. Without a `Cargo.lock` no version is locked, and none is in the id.
pub fn build_id(folder: &Path, tools: &Tools) -> io::Result<u64> {
    let mut hash = Fnv1a::new();
    for (name, text) in engine_sources(&folder.join("src"))? {
        hash.text("source", &name);
        hash.text("text", &text);
    }
    let manifest = fs::read_to_string(folder.join("Cargo.toml"))?;
    let lock = fs::read_to_string(folder.join("Cargo.lock")).unwrap_or_default();
    for (name, features) in features_asked(&manifest) {
        hash.text(&name, &features);
    }
    for package in linked(&manifest, &lock) {
        hash.text("package", &package);
    }
    hash.text("compiler", tools.compiler.trim());
    hash.text("architecture", &tools.architecture);
    for feature in &tools.features {
        hash.text("feature", feature);
    }
    Ok(hash.0)
}

/// A running FNV-1a hash of 64 bits, as `src/digest.rs` has it.
struct Fnv1a(u64);

impl Fnv1a {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Takes in a named text; both end, so that no two lists of texts run together.
    fn text(&mut self, name: &str, text: &str) {
        for byte in name.bytes().chain([0]).chain(text.bytes()).chain([0]) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// The sources of the engine by their names below `src/`, lines ended by line feeds whatever the checkout did to them.
pub fn engine_sources(src: &Path) -> io::Result<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![(src.to_owned(), String::new())];
    while let Some((folder, prefix)) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if SHELL.contains(&name.as_str()) || entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            if entry.file_type()?.is_dir() {
                folders.push((entry.path(), name + "/"));
            } else {
                let bytes = fs::read(entry.path())?;
                found.insert(name, String::from_utf8_lossy(&bytes).replace('\r', ""));
            }
        }
    }
    Ok(found)
}

/// Each dependency in a `Cargo.toml`, those of tests left out, with the features asked of it. Both spellings are read: that of people, and that
/// of packages, in which every dependency is a section.
pub fn features_asked(manifest: &str) -> BTreeMap<String, String> {
    let features = |entry: String| {
        let entry: String = entry.chars().filter(|c| !c.is_whitespace()).collect();
        let list = entry.split_once("features=[").and_then(|(_, rest)| rest.split_once(']'));
        let list = list.map_or("", |(list, _)| list).split(',').filter(|feature| !feature.is_empty());
        let mut features: BTreeSet<&str> = list.collect();
        if !entry.contains("default-features=false") {
            features.insert("default");
        }
        features.into_iter().collect::<Vec<_>>().join(",")
    };
    dependencies(manifest, "dependencies").into_iter().map(|(name, entry)| (name, features(entry))).collect()
}

/// The entries of a kind of dependencies in a `Cargo.toml`, by name; of all targets.
fn dependencies(manifest: &str, kind: &str) -> BTreeMap<String, String> {
    let mut entries: BTreeMap<String, String> = BTreeMap::new();
    // The entry that is being read; whether it ends with its line, and how many brackets are open in it.
    let (mut entry, mut is_list, mut depth) = (None, false, 0_usize);
    for line in manifest.lines() {
        let line = line.split(" #").next().unwrap_or_default().trim();
        if line.starts_with('#') {
            continue;
        }
        if depth == 0 && line.starts_with('[') {
            let section = line.trim_matches(['[', ']']);
            // `[dependencies]`, `[target.….dependencies]`, and each with a name behind.
            let below = section.rsplit_once(&format!("{kind}.")).map(|(before, name)| (before, Some(name)));
            let (before, name) = below.or_else(|| Some((section.strip_suffix(kind)?, None))).unwrap_or(("-", None));
            let is_ours = before.is_empty() || (before.starts_with("target.") && before.ends_with('.'));
            is_list = is_ours && name.is_none();
            entry = name.filter(|_| is_ours).map(|name| name.trim_matches('"').to_owned());
            if let Some(name) = &entry {
                entries.entry(name.clone()).or_default();
            }
            continue;
        }
        if depth == 0 && is_list {
            entry = line.split_once('=').map(|(name, _)| name.trim().trim_matches('"').to_owned());
        }
        if let Some(name) = &entry {
            *entries.entry(name.clone()).or_default() += line;
            depth = (depth + line.matches(['[', '{']).count()).saturating_sub(line.matches([']', '}']).count());
        }
    }
    entries
}

/// A package of a `Cargo.lock`.
#[derive(Debug, Default)]
struct Package {
    name: String,
    version: String,
    checksum: String,
    /// As the lock file writes them: a name, with a version where there are several.
    dependencies: Vec<String>,
}

/// The packages of a `Cargo.lock` that the binary is linked or built with, each with version and checksum: not those of tests and benches.
pub fn linked(manifest: &str, lock: &str) -> BTreeSet<String> {
    let packages: Vec<Package> = lock.split("[[package]]").skip(1).map(package).collect();
    let find = |dependency: &str| {
        let mut words = dependency.split(' ');
        let (name, version) = (words.next().unwrap_or_default(), words.next());
        packages.iter().find(|package| package.name == name && version.is_none_or(|version| package.version == version))
    };
    let ours = dependencies(manifest, "dependencies");
    let of_tests = dependencies(manifest, "dev-dependencies");
    let root = manifest.lines().find_map(|line| line.strip_prefix("name = ")).unwrap_or_default().trim_matches('"');
    let is_linked = |dependency: &&String| {
        let name = dependency.split(' ').next().unwrap_or_default();
        ours.contains_key(name) || !of_tests.contains_key(name)
    };
    let direct = find(root).into_iter().flat_map(|root| &root.dependencies).filter(is_linked);
    let mut open: Vec<&String> = direct.collect();
    let mut found = BTreeSet::new();
    while let Some(dependency) = open.pop() {
        let Some(package) = find(dependency) else { continue };
        if found.insert(format!("{} {} {}", package.name, package.version, package.checksum)) {
            open.extend(&package.dependencies);
        }
    }
    found
}

/// Reads what stands behind a `[[package]]`.
fn package(text: &str) -> Package {
    let mut package = Package::default();
    for line in text.lines() {
        let value = |line: &str| line.trim_matches(['"', ',']).to_owned();
        match line.split_once(" = ") {
            Some(("name", name)) => package.name = value(name),
            Some(("version", version)) => package.version = value(version),
            Some(("checksum", checksum)) => package.checksum = value(checksum),
            Some(_) => {}
            None if line.starts_with(" \"") => package.dependencies.push(value(line.trim())),
            None => {}
        }
    }
    package
}
