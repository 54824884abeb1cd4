//! The build script: hands the build id to the crate as `SIMRUN_BUILD`.

#![expect(clippy::print_stdout, reason = "cargo reads what a build script prints")]

mod build_id;

use build_id::{Tools, build_id};
use std::env;
use std::path::PathBuf;
use std::process::Command;

/// Features that change no row. The default set stands for the features in it, which are named themselves.
const NEUTRAL: [&str; 1] = ["DEFAULT"];

fn main() {
    let variable = |name: &str| env::var(name).unwrap_or_else(|_| panic!("cargo sets {name}"));
    let folder = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    for watched in ["build", "src", "Cargo.toml", "Cargo.lock"] {
        // Cargo runs the script every time if it watches a file that is not there.
        if folder.join(watched).exists() {
            println!("cargo::rerun-if-changed={watched}");
        }
    }
    let version = Command::new(variable("RUSTC")).arg("--version").output().expect("the compiler says its version");
    let enabled = env::vars().filter_map(|(name, _)| name.strip_prefix("CARGO_FEATURE_").map(str::to_owned));
    let tools = Tools {
        compiler: String::from_utf8_lossy(&version.stdout).into_owned(),
        architecture: variable("CARGO_CFG_TARGET_ARCH"),
        features: enabled.filter(|feature| !NEUTRAL.contains(&feature.as_str())).collect(),
    };
    let id = build_id(&folder, &tools).unwrap_or_else(|error| panic!("the sources cannot be read: {error}"));
    println!("cargo::rustc-env=SIMRUN_BUILD={id:016x}");
}
