//! All integration tests in one binary, so that rapier is linked once: `cargo test --release --test it oracle::` runs those of one module.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod analyze;
mod avoidable;
mod bad_scenarios;
mod book;
mod cli;
mod conditions;
mod conformance;
mod conformance_layers;
mod convex;
mod decisions;
mod documents;
mod draw;
mod drives;
mod episodes;
mod failures;
mod faults;
mod files;
mod fuzzy_sets;
mod identity;
mod interrupt;
mod isolation;
mod json;
mod latex;
mod layering;
mod oracle;
mod pairing;
mod paper_drives;
mod plan;
mod plot;
mod port_picture;
mod recorded_decisions;
mod reference;
mod regressions;
mod report;
mod reproduce;
mod schema;
mod statistics_oracle;
mod support;
mod sweeps;
mod widths;
