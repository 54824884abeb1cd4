//! Files as others write them, in `tests/cases/files`: each is read right, or refused with words that help.

use super::support::{Answer, root, simrun};
use std::fs;
use std::path::{Path, PathBuf};

fn cases() -> PathBuf {
    root().join("tests/cases/files")
}

/// The counts that `simrun map info` prints.
fn counts(stdout: &str) -> [u32; 3] {
    ["free ", "occupied ", "unknown "].map(|name| {
        let line = stdout.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}:\n{stdout}"));
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    })
}

/// Free, occupied and unknown cells of `base.yaml`.
const BASE: [u32; 3] = [6, 17, 1];

#[test]
fn maps_have_the_cells_that_their_writers_meant() {
    for (file, expected, note) in [
        ("base.yaml", BASE, ""),
        // Marks in front, line ends, YAML in other clothes.
        ("y_bom.yaml", BASE, ""),
        ("y_crlf.yaml", BASE, ""),
        ("y_tab_sep.yaml", BASE, ""),
        ("y_json.yaml", BASE, ""),
        ("y_block_dots.yaml", BASE, ""),
        // A key of others.
        ("h07_map_type.yaml", BASE, "line 7: the key `map_type` is no key of map headers and passed over"),
        // Images.
        ("i_p2.yaml", BASE, ""),
        ("i_p2_crlf.yaml", BASE, ""),
        ("i_p2_nonl.yaml", BASE, ""),
        ("i_p5_comments.yaml", BASE, ""),
        ("i_p5_16.yaml", BASE, ""),
        ("i_p5_max100.yaml", BASE, ""),
        ("i_png16.yaml", BASE, ""),
        ("i_png_pal.yaml", BASE, ""),
        ("i_png_rgba.yaml", BASE, ""),
        ("i_bmp.yaml", BASE, ""),
        // Without a header the grey of unknown cells is unknown.
        ("m.pgm", BASE, ""),
        ("m.png", BASE, ""),
        // White space where the format's own reader passes over it.
        ("map_base.map", [39, 9, 0], ""),
        ("map_trail.map", [39, 9, 0], ""),
        ("map_tabs.map", [39, 9, 0], ""),
        ("water.map", [6, 12, 0], "water (`W`) is blocked, also from water to water: 12 cells"),
        // Real spellings of headers. 205 is free by a threshold of 0.25, as for Nav2; that is said.
        (
            "headers/h01_mode_int_yaw.yaml",
            [7, 17, 0],
            "grey 205, which map savers write for unknown, is free by `free_thresh`: 1 cell\n",
        ),
        ("headers/h02_six_decimals.yaml", BASE, ""),
        ("headers/h04_scale_1_0.yaml", [7, 17, 0], ""),
        ("headers/h05_scale_99_01.yaml", [7, 17, 0], ""),
        ("headers/h10_order_blank_tail.yaml", [6, 18, 0], ""),
        ("headers/h11_mixed_ints.yaml", [7, 17, 0], "grey 205"),
        ("headers/h14_two_spaces.yaml", BASE, ""),
        ("headers/h16_thresh_06_03.yaml", [7, 17, 0], "grey 205"),
        ("headers/h17_yaw.yaml", BASE, ""),
        ("headers/h19_negate_1.yaml", [17, 7, 0], ""),
        ("headers/h20_yaw_one_int.yaml", [7, 17, 0], "grey 205"),
        ("headers/h22_095_090.yaml", [7, 17, 0], "grey 205"),
        ("headers/h25_1cm.yaml", [7, 17, 0], "grey 205"),
        ("headers/h26_quoted_resolution.yaml", BASE, ""),
        ("headers/h29_nine_decimals.yaml", BASE, ""),
    ] {
        let Answer { code, stdout, stderr } = simrun(&cases()).args(["map", "info", file]).answer();
        assert_eq!(code, 0, "{file}: {stderr}");
        assert_eq!(counts(&stdout), expected, "{file}");
        assert!(if note.is_empty() { stderr.is_empty() } else { stderr.contains(note) }, "{file}: {stderr}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_its_place_and_what_helps() {
    for (file, expected) in [
        (
            "i_p5_crlf.yaml",
            "i_p5_crlf.pgm: found 25 bytes of pixels, expected 24, as 6 x 4 pixels have; were line ends turned",
        ),
        (
            "y_word.yaml",
            "line 1, column 1: invalid type: string \"hello\", expected a mapping of the keys `image`, `resolution`",
        ),
        ("y_latin1.yaml", "line 1, column 10: found the byte 0xFC, expected UTF-8 text; save the file as UTF-8"),
        ("y_dup_key.yaml", "line 7, column 1: twice the key `resolution`"),
        ("h13_absolute_path.yaml", "`m.pgm` lies beside the YAML file: write `image: m.pgm`"),
        ("big16385.png", "found more pixels, expected a PGM, PNG or BMP image of at most 16384 x 16384 pixels"),
        ("headers/h08_image_name_wrong.yaml", "empty.pgm: found No such file"),
        ("headers/h23_swapped.yaml", "expected a free threshold below the occupied one"),
    ] {
        let Answer { code, stdout, stderr } = simrun(&cases()).args(["map", "info", file]).answer();
        assert_eq!((code, &stdout[..]), (2, ""), "{file}: {stderr}");
        assert!(stderr.starts_with(&format!("error: {file}: ")), "{file}: {stderr}");
        assert!(stderr.contains(expected), "{file}: {stderr}");
        assert!(!stderr.contains("scenario"), "{file}: {stderr}");
    }
}

/// Exit code, rows by column, stderr of `simrun plan` in the folder of the cases.
fn plan(folder: &Path, args: &[&str]) -> (i32, Vec<csv::StringRecord>, String) {
    let Answer { code, stdout, stderr } = simrun(folder).arg("plan").args(args).answer();
    let rows = csv::Reader::from_reader(stdout.as_bytes()).into_records().map(Result::unwrap).collect();
    (code, rows, stderr)
}

const FOUND: usize = 7;
const OPTIMAL: usize = 8;
const LENGTH: usize = 9;
const RATIO: usize = 11;
const NOTE: usize = 16;

#[test]
fn queries_are_read_whatever_parts_their_columns_and_whatever_their_file_is_called() {
    let scratch = tempfile::tempdir().unwrap();
    fs::copy(cases().join("map_base.map"), scratch.path().join("map_base.map")).unwrap();
    let tabs = fs::read_to_string(cases().join("s_txt.txt")).unwrap();
    let spaces = fs::read_to_string(cases().join("s_spaces.scen")).unwrap();
    let table = "start_col,start_row,goal_col,goal_row,length_cells\n0,0,7,5,9.24264069\n0,3,7,3,7.00000000\n";
    for (name, text, option) in [
        ("spaces.scen", spaces.clone(), "--scen"),
        ("spaces.scen", spaces.replace('\n', "\r\n"), "--scen"),
        ("version.scen", spaces.replace("version 1", "version 1.0 "), "--scen"),
        ("tabs.txt", tabs.clone(), "--scen"),
        ("TABS.SCEN", tabs.clone(), "--scen"),
        ("none", tabs.clone(), "--scen"),
        ("marked.scen", format!("\u{feff}{tabs}"), "--scen"),
        ("returns.scen", tabs.replace('\n', "\r"), "--scen"),
        // The content decides for --queries.
        ("tabs.csv", tabs.clone(), "--queries"),
        ("table.scen", table.to_owned(), "--queries"),
        ("table.csv", format!("\u{feff}{}", table.replace('\n', "\r\n")), "--queries"),
        ("returns.csv", table.replace('\n', "\r"), "--queries"),
    ] {
        fs::write(scratch.path().join(name), text).unwrap();
        let (code, rows, stderr) = plan(scratch.path(), &["map_base.map", option, name]);
        assert_eq!((code, rows.len()), (0, 2), "{name}: {stderr}");
        let lengths: Vec<f64> = rows.iter().map(|row| row[LENGTH].parse().unwrap()).collect();
        assert!(
            (lengths[0] - (10.0 + std::f64::consts::SQRT_2)).abs() < 1e-9 && lengths[1] == 7.0,
            "{name}: {lengths:?}"
        );
        assert!(!stderr.contains("note: "), "{name}: {stderr}");
    }
    fs::write(scratch.path().join("table.csv"), table).unwrap();
    let (code, _, stderr) = plan(scratch.path(), &["map_base.map", "--scen", "table.csv"]);
    assert!(code == 2 && stderr.contains("table.csv: line 1, column 1: found `start_col,"), "{stderr}");
}

#[test]
fn optima_are_compared_by_the_digits_they_are_printed_with() {
    let (code, rows, stderr) = plan(&cases(), &["map_base.map", "--scen", "tol.scen"]);
    assert_eq!((code, rows.len()), (0, 7), "{stderr}");
    assert!(stderr.contains("7 of 7 equal the optimum, 0 are shorter"), "{stderr}");
    assert!(stderr.contains("note: tol.scen: line 2: the queries are for the map `m`"), "{stderr}");
}

#[test]
fn a_bad_query_is_a_row_with_its_reason() {
    let (code, rows, stderr) = plan(&cases(), &["map_base.map", "--scen", "onebad.scen", "--global", "a_star,jps"]);
    assert_eq!((code, rows.len()), (0, 6), "{stderr}");
    let found: Vec<&str> = rows.iter().map(|row| &row[FOUND]).collect();
    assert_eq!(found, ["1", "1", "0", "0", "1", "1"]);
    assert_eq!(&rows[2][NOTE], "the start 2,1 is occupied (rows count from the top)");
    assert_eq!((&rows[0][NOTE], &rows[2][LENGTH]), ("", ""));
    let expected =
        "note: onebad.scen: 1 of 3 queries cannot be asked, see the column `note`; line 3: the start 2,1 is occupied";
    assert!(stderr.contains(expected), "{stderr}");
    assert!(stderr.contains("a_star: 3 queries, 2 found; 2 of 2 equal the optimum"), "{stderr}");

    // Outside, by far as well; none that can be asked is an error.
    let scratch = tempfile::tempdir().unwrap();
    fs::copy(cases().join("map_base.map"), scratch.path().join("map_base.map")).unwrap();
    let header = "start_col,start_row,goal_col,goal_row\n";
    fs::write(scratch.path().join("q.csv"), format!("{header}0,0,1,1\n0,0,8,0\n0,-2147483648,0,0\n")).unwrap();
    let (code, rows, stderr) = plan(scratch.path(), &["map_base.map", "--queries", "q.csv"]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(&rows[1][NOTE], "the goal 8,0 lies outside the map of 8 columns and 6 rows");
    assert_eq!(&rows[2][NOTE], "the start 0,-2147483648 lies outside the map of 8 columns and 6 rows");
    fs::write(scratch.path().join("q.csv"), format!("{header}0,0,8,0\n2,1,0,0\n")).unwrap();
    let (code, rows, stderr) = plan(scratch.path(), &["map_base.map", "--queries", "q.csv"]);
    assert!(code == 2 && rows.is_empty(), "{stderr}");
    assert!(
        stderr.contains("q.csv: none of 2 queries can be asked of this map, the first because of line 2: the goal"),
        "{stderr}"
    );
    // A line that is no query is a fault of the file.
    fs::write(scratch.path().join("q.csv"), format!("{header}0,0,1\n")).unwrap();
    let (code, _, stderr) = plan(scratch.path(), &["map_base.map", "--queries", "q.csv"]);
    assert!(code == 2 && stderr.contains("q.csv: line 2, `goal_row`: expected a whole number, found ``"), "{stderr}");
}

#[test]
fn queries_of_another_map_are_refused_or_noted() {
    let (code, rows, stderr) = plan(&cases(), &["map_base.map", "--scen", "s_othersize.scen"]);
    assert!(code == 2 && rows.is_empty(), "{stderr}");
    let expected =
        "s_othersize.scen: line 2: found queries for a map of 16 x 12 cells, expected 8 x 6 as map_base.map has";
    assert!(stderr.contains(expected), "{stderr}");
}

#[test]
fn no_queries_is_an_error() {
    let scratch = tempfile::tempdir().unwrap();
    fs::copy(cases().join("map_base.map"), scratch.path().join("map_base.map")).unwrap();
    let header = fs::read_to_string(cases().join("t_headeronly.csv")).unwrap();
    for (option, text) in [("--queries", &header[..]), ("--scen", "version 1\n"), ("--queries", "version 1\n\n")] {
        fs::write(scratch.path().join("q"), text).unwrap();
        let (code, rows, stderr) = plan(scratch.path(), &["map_base.map", option, "q"]);
        assert!(code == 2 && rows.is_empty() && stderr.contains("q: found no queries"), "{text}: {stderr}");
    }
}

#[test]
fn a_length_of_0_between_different_cells_is_no_optimum() {
    let (code, _, stderr) = plan(&cases(), &["map_base.map", "--queries", "opt0.csv"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(
        stderr.contains("opt0.csv: line 3, `length_cells`: expected a number of at least 0, found `-3`"),
        "{stderr}"
    );

    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("two.map"), "type octile\nheight 1\nwidth 4\nmap\n..@.\n").unwrap();
    let scen = "version 1\n0 two.map 4 1 0 0 1 0 0\n0 two.map 4 1 0 0 3 0 0\n0 two.map 4 1 1 0 1 0 0\n0 two.map 4 1 0 0 1 0 1.0\n";
    fs::write(scratch.path().join("two.scen"), scen).unwrap();
    let (code, rows, stderr) = plan(scratch.path(), &["two.map", "--scen", "two.scen"]);
    assert_eq!(code, 0, "{stderr}");
    let expected = "a_star: 4 queries, 3 found; 2 of 2 equal the optimum, 0 are shorter, ratio mean 1.000000, worst 1.000000; \
                    1 found where the file gives the length 0, which stands for no way";
    assert!(stderr.contains(expected), "{stderr}");
    let column = |at: usize| rows.iter().map(|row| row[at].to_owned()).collect::<Vec<_>>();
    assert_eq!(column(OPTIMAL), ["0", "0", "0", "1"]);
    assert_eq!(column(RATIO), ["", "", "", "1"]);
    assert_eq!(column(NOTE), ["the file gives the length 0, which stands for no way", "no path exists", "", ""]);
}

#[test]
fn unknown_cells_are_called_so_and_may_be_planned_through() {
    let query = ["base.yaml", "--from", "1,1", "--to", "3,1"];
    let (code, _, stderr) = plan(&cases(), &query);
    assert!(
        code == 2 && stderr.contains("the goal 3,1 is unknown, which counts as occupied; --unknown free"),
        "{stderr}"
    );
    let (code, rows, stderr) = plan(&cases(), &[&query[..], &["--unknown", "free"]].concat());
    assert_eq!((code, &rows[0][LENGTH]), (0, "2"), "{stderr}");
}

#[test]
fn an_end_within_the_inflation_is_said() {
    let (_, rows, _) = plan(&cases(), &["th2b.txt", "--from", "0,0", "--to", "3,0", "--inflate", "1"]);
    assert_eq!(&rows[0][NOTE], "the start is nearer than --inflate 1 m to an obstacle");
}

#[test]
fn points_in_metres_are_those_of_the_maps_frame() {
    // Cell 1,1 of the file: 0.05 m a cell, 4 rows, origin [-10, -5].
    for (from, to) in [("-9.93,-4.88", "-9.79,-4.92"), ("-9.949,-4.851", "-9.751,-4.949")] {
        let (code, rows, stderr) = plan(&cases(), &["base.yaml", "--metres", "--from", from, "--to", to]);
        assert_eq!(code, 0, "{stderr}");
        assert_eq!([&rows[0][2], &rows[0][3], &rows[0][4], &rows[0][5]], ["1", "1", "4", "2"], "{from}");
    }
    // Turned by 90°: the map's x axis points to the world's +y.
    let (code, rows, stderr) = plan(&cases(), &["yaw90.yaml", "--metres", "--from", "9.5,20.5", "--to", "8.5,23.5"]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!([&rows[0][2], &rows[0][4]], ["0", "3"]);
    for (args, expected) in [
        (
            ["--metres", "--from", "0,0", "--to", "-9.93,-4.88"],
            "--from 0,0 m lies outside the map, which reaches from -10,-5 to -9.7,-4.8 m",
        ),
        (
            ["--unknown=free", "--from", "1.5,1", "--to", "3,1"],
            "--from: expected the whole numbers COL,ROW, found 1.5,1; --metres",
        ),
        (
            ["--unknown=free", "--from", "1,1", "--to", "-1,1"],
            "the goal -1,1 lies outside the map of 6 columns and 4 rows",
        ),
        (["--metres", "--from", "nan,1", "--to", "1,1"], "expected two numbers such as 3,14, found nan,1"),
    ] {
        let (code, _, stderr) = plan(&cases(), &[&["base.yaml"], &args[..]].concat());
        assert!(code == 2 && stderr.contains(expected), "{args:?}: {stderr}");
    }
}

#[test]
fn paths_are_written_in_cells_of_the_file_and_in_metres() {
    let scratch = tempfile::tempdir().unwrap();
    let map = cases().join("base.yaml").to_string_lossy().into_owned();
    let args = [
        &map,
        "--from",
        "1,1",
        "--to",
        "4,2",
        "--unknown",
        "free",
        "--paths",
        "paths.csv",
        "--global",
        "a_star,theta_star",
    ];
    let (code, rows, stderr) = plan(scratch.path(), &args);
    assert_eq!(code, 0, "{stderr}");
    let text = fs::read_to_string(scratch.path().join("paths.csv")).unwrap();
    assert!(text.starts_with("query,global,point,col,row,x_m,y_m\n0,a_star,0,1,1,-9.925,-4.875\n"), "{text}");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let points: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    for (row, planner) in rows.iter().zip(["a_star", "theta_star"]) {
        let of_planner: Vec<[f64; 4]> = points
            .iter()
            .filter(|point| &point[1] == planner)
            .map(|point| [3, 4, 5, 6].map(|at| point[at].parse().unwrap()))
            .collect();
        let square = |d: f64| d * d;
        let length = |x: usize, y: usize| -> f64 {
            of_planner.windows(2).map(|p| (square(p[1][x] - p[0][x]) + square(p[1][y] - p[0][y])).sqrt()).sum()
        };
        assert!((length(0, 1) - row[LENGTH].parse::<f64>().unwrap()).abs() < 1e-6, "{planner}: {text}");
        assert!((length(2, 3) - row[LENGTH + 1].parse::<f64>().unwrap()).abs() < 1e-6, "{planner}: {text}");
        assert_eq!(of_planner.last().unwrap()[..2], [4.0, 2.0], "{planner}: {text}");
    }
    // Where something is read nothing is written.
    fs::copy(cases().join("g_corner.txt"), scratch.path().join("g.txt")).unwrap();
    for args in [["--paths", "g.txt"], ["--out", "./g.txt"]] {
        let (code, _, stderr) = plan(scratch.path(), &[&["g.txt", "--from", "2,2", "--to", "3,1"], &args[..]].concat());
        assert!(code == 2 && stderr.contains("g.txt is an input"), "{stderr}");
    }
    assert_eq!(fs::read(scratch.path().join("g.txt")).unwrap(), fs::read(cases().join("g_corner.txt")).unwrap());
}

#[test]
fn corners_are_neither_cut_nor_touched() {
    for global in ["a_star", "dijkstra", "bfs", "jps", "theta_star", "improved_dijkstra"] {
        let (_, rows, _) = plan(&cases(), &["g_corner.txt", "--from", "2,2", "--to", "3,1", "--global", global]);
        assert_eq!(&rows[0][LENGTH], "6", "{global}");
    }
    let (_, rows, _) = plan(&cases(), &["th2b.txt", "--from", "0,1", "--to", "3,0", "--global", "theta_star"]);
    let length: f64 = rows[0][LENGTH].parse().unwrap();
    assert!((length - (2.0 + std::f64::consts::SQRT_2)).abs() < 1e-9, "{length}");
}

#[test]
fn a_turned_map_is_checked_in_its_own_frame() {
    for yaw in ["yaw90", "yawm90"] {
        simrun(&cases()).args(["check", &format!("sc_{yaw}_ff.yaml")]).ends_with(0);
        for end in ["start", "goal"] {
            let refused = simrun(&cases()).args(["check", &format!("sc_{yaw}_occ_{end}.yaml")]).ends_with(2);
            assert!(refused.stderr.contains(end), "{}", refused.stderr);
        }
    }
}

/// Black at a threshold of 1 is unknown in ROS 1 and Nav2 up to Jazzy, whose rule simrun follows, and occupied in newer ones.
#[test]
fn a_pixel_on_a_threshold_is_noted() {
    let scratch = tempfile::tempdir().unwrap();
    let out = scratch.path().join("o.txt");
    let converted = simrun(&cases()).args(["map", "convert", "th_one.yaml"]).arg(&out).ends_with(0);
    assert_eq!(fs::read_to_string(out).unwrap(), "#####.\n");
    assert!(
        converted.stderr.contains("darkness that is exactly a threshold is unknown, as in ROS 1 and Nav2 up to Jazzy"),
        "{}",
        converted.stderr
    );
}

/// A key that is passed over may be a misspelt one: whoever checks or runs a scenario hears of it.
#[test]
fn a_foreign_key_of_a_header_is_noted_wherever_the_map_is_used() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::copy(cases().join("yaw.pgm"), folder.join("yaw.pgm")).unwrap();
    let header = fs::read_to_string(cases().join("yaw90.yaml")).unwrap();
    fs::write(folder.join("yaw90.yaml"), format!("{header}mod: scale\n")).unwrap();
    fs::copy(cases().join("sc_yaw90_ff.yaml"), folder.join("s.yaml")).unwrap();
    let expected =
        "note: yaw90.yaml: line 7: the key `mod` is no key of map headers and passed over; did you mean `mode`?";
    let checked = simrun(folder).args(["check", "s.yaml"]).ends_with(0);
    assert!(checked.stdout.contains(expected), "{}", checked.stdout);
    let run = simrun(folder).args(["s.yaml"]).ends_with(0);
    assert!(run.stderr.contains(expected), "{}", run.stderr);
    let args = ["yaw90.yaml", "--metres", "--from", "9.5,20.5", "--to", "8.5,23.5"];
    assert!(plan(folder, &args).2.contains(&expected.replace("yaw90.yaml: ", "")));
    // One that is needed is missing as well.
    fs::write(folder.join("yaw90.yaml"), header.replace("resolution", "resolutoin")).unwrap();
    let refused = simrun(folder).args(["map", "info", "yaw90.yaml"]).ends_with(2);
    let expected = "line 2, column 1: missing key `resolution`; unknown key `resolutoin`, did you mean `resolution`?";
    assert!(refused.stderr.contains(expected), "{}", refused.stderr);
}

/// The files of a folder with their bytes.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found.into_iter().map(|file| (file.clone(), fs::read(file).unwrap())).collect()
}

#[test]
fn maps_that_are_there_are_not_replaced_unasked() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    for name in ["site.map", "site.yaml", "site.pgm"] {
        fs::copy(cases().join(name), folder.join(name)).unwrap();
    }
    let before = contents(folder);
    for (args, expected) in [
        (
            ["site.map", "site.yaml"],
            "`site.yaml` and `site.pgm` are there already: write elsewhere, or replace with --force",
        ),
        (["site.yaml", "site.yaml"], "`site.yaml` and `site.pgm` are there already"),
        (["site.yaml", "site.pgm"], "`site.pgm` is there already"),
        // Its image is there, its header is not.
        (["site.map", "site.yml"], "`site.pgm` is there already"),
    ] {
        let refused = simrun(folder).args(["map", "convert"]).args(args).ends_with(2);
        assert!(refused.stderr.contains(expected) && refused.stdout.is_empty(), "{args:?}: {}", refused.stderr);
        assert_eq!(contents(folder), before, "{args:?}");
    }
    simrun(folder).args(["map", "convert", "site.map", "site.yaml", "--force"]).ends_with(0);
    let info = simrun(folder).args(["map", "info", "site.yaml"]).ends_with(0);
    assert_eq!(counts(&info.stdout), [39, 9, 0]);

    // A picture: neither the map, nor its image, nor the preview.
    fs::copy(cases().join("m.png"), folder.join("photo.png")).unwrap();
    for there in ["plan.yaml", "plan.pgm", "plan.preview.png"] {
        fs::write(folder.join(there), "mine").unwrap();
        let before = contents(folder);
        let refused = simrun(folder).args(["map", "from-image", "photo.png", "plan.yaml"]).ends_with(2);
        assert!(refused.stderr.contains(&format!("`{there}` is there already")), "{}", refused.stderr);
        assert_eq!(contents(folder), before, "{there}");
        fs::remove_file(folder.join(there)).unwrap();
    }
    simrun(folder).args(["map", "from-image", "photo.png", "plan.yaml"]).ends_with(0);
    simrun(folder).args(["map", "from-image", "photo.png", "plan.yaml"]).ends_with(2);
    simrun(folder).args(["map", "from-image", "photo.png", "plan.yaml", "--force"]).ends_with(0);
}

#[test]
fn absurd_resolutions_are_refused_where_they_are_read() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::copy(cases().join("m.pgm"), folder.join("m.pgm")).unwrap();
    let base = fs::read_to_string(cases().join("base.yaml")).unwrap();
    for side in ["1e160", "1e308", "1e-160", "10001"] {
        fs::write(folder.join("far.yaml"), base.replace("0.05", side)).unwrap();
        let refused = simrun(folder).args(["map", "info", "far.yaml"]).ends_with(2);
        assert!(refused.stderr.contains("expected 0.0001 to 10000 m"), "{}", refused.stderr);
        let refused = simrun(folder).args(["map", "info", "m.pgm", "--resolution-m", side]).ends_with(2);
        assert!(refused.stderr.contains("expected 0.0001 to 10000 m"), "{}", refused.stderr);
        for map in
            ["{ros: {file: far.yaml}}".to_owned(), format!("{{empty: {{cols: 20, rows: 20, resolution_m: {side}}}}}")]
        {
            let scenario =
                format!("map: {map}\nstart: [1, 1]\ngoal: [2, 2]\nstacks: {{global: [a_star], local: [dwa]}}\n");
            fs::write(folder.join("far_scenario.yaml"), scenario).unwrap();
            let refused = simrun(folder).args(["check", "far_scenario.yaml"]).ends_with(2);
            assert!(refused.stderr.contains("expected 0.0001 to 10000 m"), "{}", refused.stderr);
        }
    }
}

/// A small scenario that runs at once.
const SCENARIO: &str = "map: {ascii: {rows: ['......', '......', '......']}}\nstart: [1, 1]\ngoal: [4, 2]\n\
                        obstacles: {unknown_static: [{random: {count: 1}}]}\n\
                        stacks: {global: [a_star], local: [pure_pursuit]}\nepisodes: 2\nseed: 5000001\n";

/// Each line of a file ended in another way, as git and spreadsheets do.
fn turn_lines(file: &Path, end: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(!text.contains('\r'));
    fs::write(file, text.replace('\n', end)).unwrap();
}

#[test]
fn results_whose_line_ends_were_turned_are_read_compared_and_continued() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("small.yaml"), SCENARIO).unwrap();
    simrun(folder).args(["small.yaml", "--out", "two"]).ends_with(0);
    simrun(folder).args(["small.yaml", "--out", "three", "--episodes", "3"]).ends_with(0);
    let run = |name: &str| folder.join(name).join("small");
    let dir = if run("two").is_dir() { "two/small" } else { "two" };
    let longer = dir.replace("two", "three");
    let table = folder.join(dir).join("episodes.csv");
    let (lf, expected) = (fs::read(&table).unwrap(), simrun(folder).args(["analyze", dir]).ends_with(0).stdout);
    for end in ["\r\n", "\r"] {
        turn_lines(&table, end);
        let crlf = simrun(folder).args(["analyze", dir]).ends_with(0);
        assert_eq!(crlf.stdout, expected, "{end:?}");
        simrun(folder).args(["analyze", &longer, "--baseline", dir]).answer();
        fs::write(&table, &lf).unwrap();
    }
    fs::write(&table, [b"\xef\xbb\xbf", &lf[..]].concat()).unwrap();
    assert_eq!(simrun(folder).args(["analyze", dir]).ends_with(0).stdout, expected);
    fs::write(&table, &lf).unwrap();

    // What an older version wrote, with CR LF.
    let as_lf = simrun(&cases()).args(["analyze", "ep_crlf.csv"]).ends_with(0).stdout;
    let plain = fs::read_to_string(cases().join("ep_crlf.csv")).unwrap().replace("\r\n", "\n");
    fs::write(folder.join("ep_crlf.csv"), plain).unwrap();
    assert_eq!(simrun(folder).args(["analyze", "ep_crlf.csv"]).ends_with(0).stdout, as_lf);

    // A run goes on as if nothing had been turned, and ends with the same bytes.
    for name in ["episodes.csv", "states.csv", "timings.csv", "manifest.json"] {
        turn_lines(&folder.join(dir).join(name), "\r\n");
    }
    simrun(folder).args(["small.yaml", "--out", "two", "--episodes", "3"]).ends_with(0);
    for name in ["episodes.csv", "states.csv", "summary.csv"] {
        let read = |dir: &str| fs::read(folder.join(dir).join(name)).unwrap();
        assert_eq!(read(dir), read(&longer), "{name}");
    }
    assert!(!fs::read_to_string(folder.join(dir).join("timings.csv")).unwrap().contains('\r'));
}

/// Every way in which a command is given a file, with `FILE` in its place.
const DOORS: [&[&str]; 10] = [
    &["map", "info", "FILE.map"],
    &["map", "info", "FILE.yaml"],
    &["map", "info", "FILE.pgm"],
    &["map", "info", "FILE.txt"],
    &["map", "from-image", "FILE.png", "out.map"],
    &["plan", "good.map", "--scen", "FILE.map"],
    &["plan", "good.map", "--queries", "FILE.map"],
    &["check", "FILE.yaml"],
    &["check", "names_map.yaml"],
    &["analyze", "FILE.csv"],
];

#[cfg(unix)]
#[test]
fn pipes_devices_and_folders_are_refused_at_every_door() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::copy(cases().join("map_base.map"), folder.join("good.map")).unwrap();
    let image = fs::read_to_string(cases().join("base.yaml")).unwrap().replace("m.pgm", "FILE.pgm");
    fs::write(folder.join("names_image.yaml"), image).unwrap();
    let scenario =
        "map: {movingai: {file: FILE.map}}\nstart: [0, 0]\ngoal: [1, 1]\nstacks: {global: [a_star], local: [dwa]}\n";
    fs::write(folder.join("names_map.yaml"), scenario).unwrap();
    let people = SCENARIO.replace("unknown_static: [{random: {count: 1}}]", "moving: [{replay: {file: FILE.csv}}]");
    fs::write(folder.join("names_people.yaml"), people).unwrap();
    let more: [&[&str]; 2] = [&["map", "info", "names_image.yaml"], &["check", "names_people.yaml"]];
    let endings = ["map", "yaml", "pgm", "txt", "png", "csv"].map(|ending| folder.join(format!("FILE.{ending}")));
    type Make = fn(&Path);
    let kinds: [(&str, Make); 3] = [
        ("found a named pipe, expected a regular file", |file| {
            assert!(std::process::Command::new("mkfifo").arg(file).status().unwrap().success());
        }),
        ("found a device, expected a regular file", |file| std::os::unix::fs::symlink("/dev/zero", file).unwrap()),
        ("found a folder, expected a regular file", |file| fs::create_dir(file).unwrap()),
    ];
    for (expected, make) in kinds {
        for file in &endings {
            make(file);
        }
        for args in DOORS.iter().chain(&more) {
            if args.contains(&"analyze") && expected.contains("folder") {
                // A folder is asked for the table in it.
                continue;
            }
            let refused = simrun(folder).args(*args).answer();
            let shown = expected.split(',').next().unwrap().to_owned();
            assert!(matches!(refused.code, 1 | 2) && refused.stdout.is_empty(), "{args:?}: {}", refused.stderr);
            assert!(refused.stderr.contains(&shown), "{args:?}: {}", refused.stderr);
        }
        for file in &endings {
            if fs::symlink_metadata(file).unwrap().is_dir() {
                fs::remove_dir(file).unwrap()
            } else {
                fs::remove_file(file).unwrap()
            }
        }
    }
}

/// Files of a TiB, all of it a hole that takes no room on the disk: refused at once, before anything is allocated.
#[test]
fn huge_files_are_refused_at_every_door() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::copy(cases().join("map_base.map"), folder.join("good.map")).unwrap();
    let scenario =
        "map: {movingai: {file: FILE.map}}\nstart: [0, 0]\ngoal: [1, 1]\nstacks: {global: [a_star], local: [dwa]}\n";
    fs::write(folder.join("names_map.yaml"), scenario).unwrap();
    for ending in ["map", "yaml", "pgm", "txt", "png", "csv"] {
        let file = fs::File::create(folder.join(format!("FILE.{ending}"))).unwrap();
        if file.set_len(1 << 40).is_err() {
            // Not every file system has holes, or files so large.
            return;
        }
    }
    for args in DOORS {
        let refused = simrun(folder).args(args).answer();
        assert!(matches!(refused.code, 1 | 2) && refused.stdout.is_empty(), "{args:?}: {}", refused.stderr);
        let expected = ["found 1 TiB, expected at most", "larger than 1024 KiB", "the line is longer than 1 MiB"];
        assert!(expected.iter().any(|expected| refused.stderr.contains(expected)), "{args:?}: {}", refused.stderr);
    }
}

/// An excerpt in a message shows a line of the width of a screen, however long the line is.
#[test]
fn a_broken_map_is_shown_where_it_is_broken_and_no_wider() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let row = ".".repeat(16_000);
    let map = format!("\u{feff}type octile\r\nheight 1\r\nwidth 16001\r\nmap\r\n{row}x\r\n");
    fs::write(folder.join("wide.map"), map).unwrap();
    let scenario =
        "map: {movingai: {file: wide.map}}\nstart: [0, 0]\ngoal: [1, 1]\nstacks: {global: [a_star], local: [dwa]}\n";
    fs::write(folder.join("wide.yaml"), scenario).unwrap();
    let refused = simrun(folder).args(["check", "wide.yaml"]).ends_with(2);
    assert!(refused.stderr.contains("wide.map:5:16001"), "{}", refused.stderr);
    assert!(refused.stderr.len() < 2000, "{} bytes", refused.stderr.len());
}
