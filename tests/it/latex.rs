//! `--format latex`: tables that a paper takes in as they are.

use super::support::{root, simrun};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Cells of a row of a table, spans counted as the columns that they cover.
fn columns(line: &str) -> usize {
    let spans = line.split("\\multicolumn{").skip(1).map(|rest| {
        let count: usize = rest.split('}').next().unwrap().parse().unwrap();
        count - 1
    });
    line.replace("\\&", "").matches('&').count() + 1 + spans.sum::<usize>()
}

/// Columns of `\begin{tabular}{…}`: letters outside of braces.
fn declared(line: &str) -> usize {
    let spec = line.strip_prefix("\\begin{tabular}{").unwrap();
    let mut depth = 0;
    let letters = spec.chars().filter(|c| {
        depth += i32::from(*c == '{') - i32::from(*c == '}');
        depth == 0 && "lrcp".contains(*c)
    });
    letters.count()
}

#[track_caller]
fn assert_is_latex(text: &str) {
    let mut open = None;
    let mut tables = 0;
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('%')) {
        if line.starts_with("\\begin{tabular}") {
            open = Some(declared(line));
        } else if line == "\\end{tabular}" {
            open = None;
            tables += 1;
        } else if let Some(row) = line.strip_suffix(" \\\\") {
            assert_eq!(Some(columns(row)), open, "{row}\n{text}");
        } else {
            assert!(["\\toprule", "\\midrule", "\\bottomrule", "\\addlinespace"].contains(&line), "{line}\n{text}");
        }
        // What would be a command or a subscript.
        let bare = line.replace("\\_", "").replace("\\%", "").replace("\\#", "");
        assert!(!bare.contains(['_', '%', '#']), "{line}");
    }
    assert!(tables > 0 && open.is_none(), "{text}");
    typeset(text);
}

/// Sets the tables where there is a LaTeX.
fn typeset(text: &str) {
    let folder = tempfile::tempdir().unwrap();
    let document =
        format!("\\documentclass{{article}}\n\\usepackage{{booktabs}}\n\\begin{{document}}\n{text}\\end{{document}}\n");
    fs::write(folder.path().join("tables.tex"), document).unwrap();
    let latex = Command::new("pdflatex").current_dir(folder.path()).args(["-halt-on-error", "tables.tex"]).output();
    if let Ok(output) = latex {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
}

fn run(folder: &Path, format: &str) -> String {
    let text = "map: {empty: {cols: 20, rows: 10}}\nepisodes: 3\nsweep: {limits.speed_max_mps: [0.5, 1]}\n\
                stacks: [{name: my_a_star, global: a_star, local: dwa}, {name: the_other, global: bfs, local: pure_pursuit}]\n";
    fs::write(folder.join("two.yaml"), text).unwrap();
    simrun(folder).args(["two.yaml", "--out", "out", "--format", format]).ends_with(0).stdout
}

#[test]
fn the_summary_is_a_table_with_units_and_the_command_that_made_it() {
    let scratch = tempfile::tempdir().unwrap();
    let text = run(scratch.path(), "latex");
    assert_is_latex(&text);
    let first = text.lines().next().unwrap();
    assert!(first.starts_with("% simrun ") && first.ends_with("simrun two.yaml --out out --format latex"), "{first}");
    for part in ["length, m", "time, s", "my\\_a\\_star & 3 & 100.0 & ", "\\emph{limits.speed\\_max\\_mps = 0.5}"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let markdown = run(scratch.path(), "markdown");
    assert!(markdown.starts_with("| stack | n |") && markdown.contains("| *limits.speed_max_mps = 1* |"), "{markdown}");
}

#[test]
fn comparisons_and_rankings_are_tables() {
    let scratch = tempfile::tempdir().unwrap();
    run(scratch.path(), "text");
    for arguments in [&["out"][..], &["out", "--all-pairs", "--equivalent", "time_s=5%"], &["out", "--compare-points"]]
    {
        let text =
            simrun(scratch.path()).arg("analyze").args(arguments).args(["--format", "latex"]).ends_with(0).stdout;
        assert_is_latex(&text);
        assert!(text.lines().next().unwrap().contains("simrun analyze out"), "{text}");
    }
    let refused = simrun(root()).args(["analyze", "x", "--baseline", "x", "--format", "latex"]).answer();
    assert_eq!(refused.code, 2);
}
