//! Text that fits the width of a terminal: paragraphs, lists and tables.

/// The width of text that does not go to a terminal: lines are as long as they need to be.
pub const WIDE: usize = usize::MAX;

/// A text of one or more paragraphs, each of whose lines is broken between words; a line that goes on is indented as far as it began.
/// Lines that follow each other are one paragraph where they have to be broken.
pub fn paragraph(text: &str, width: usize) -> String {
    if text.lines().all(|line| line.chars().count() <= width) {
        return text.to_owned();
    }
    let mut whole = String::new();
    for part in text.split_inclusive("\n\n") {
        let body = part.trim_end_matches('\n');
        let ends = &part[body.len()..];
        let indent: String = body.chars().take_while(|&c| c == ' ').collect();
        whole += &hanging(&indent, indent.len(), body, width);
        whole.pop();
        whole += ends;
    }
    whole
}

/// A text in which every line that is too long is broken between words, and goes on where it began.
pub fn lines(text: &str, width: usize) -> String {
    let line = |line: &str| {
        if length(line) <= width {
            return format!("{line}\n");
        }
        let indent = line.chars().take_while(|&c| c == ' ').count();
        hanging(&" ".repeat(indent), indent, line, width)
    };
    text.lines().map(line).collect()
}

/// `head`, then the words of `text` in lines of at most `width` characters, of which all but the first begin at column `indent`. It ends
/// with a newline; a word that is longer than a line stands alone.
pub fn hanging(head: &str, indent: usize, text: &str, width: usize) -> String {
    let mut whole = String::new();
    let mut line = head.to_owned();
    let mut is_begun = false;
    for word in text.split_whitespace() {
        let space = usize::from(is_begun);
        if is_begun && line.chars().count() + space + word.chars().count() > width {
            whole += line.trim_end();
            whole.push('\n');
            line = " ".repeat(indent);
        } else if is_begun {
            line.push(' ');
        }
        line += word;
        is_begun = true;
    }
    whole += line.trim_end();
    whole.push('\n');
    whole
}

/// Rows of cells as columns with two spaces between; the first row is the head. The first `left` columns name a row and stand to the
/// left, the others to the right.
///
/// Columns that do not fit beside each other go on below, with the names again; names that are too long are broken.
pub fn aligned(rows: &[Vec<String>], left: usize, width: usize) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let natural = |column: usize| rows.iter().map(|row| length(&row[column])).max().unwrap_or_default();
    let mut widths: Vec<usize> = (0..columns).map(natural).collect();
    let together = |widths: &[usize]| widths.iter().map(|width| width + 2).sum::<usize>().saturating_sub(2);
    // What names a row is on every part.
    let names = left.max(1).min(columns);
    if together(&widths) > width {
        let least = |column: usize| {
            let longest = rows.iter().flat_map(|row| pieces(&row[column])).map(length).max().unwrap_or_default();
            longest + INDENT.len()
        };
        // The widest name gives way first, as far as its pieces let it.
        while together(&widths[..names]) > width * 3 / 5 {
            let widest =
                (0..names).filter(|&column| widths[column] > least(column)).max_by_key(|&column| widths[column]);
            match widest {
                Some(column) => widths[column] -= 1,
                None => break,
            }
        }
    }
    let mut text = String::new();
    let mut first = names;
    while first < columns || text.is_empty() {
        let mut shown: Vec<usize> = (0..names).collect();
        for column in first..columns {
            shown.push(column);
            let taken: Vec<usize> = shown.iter().map(|&column| widths[column]).collect();
            if together(&taken) > width && column > first {
                shown.pop();
                break;
            }
        }
        if !text.is_empty() {
            text.push('\n');
        }
        for row in rows {
            let cells: Vec<Vec<String>> = shown.iter().map(|&column| broken(&row[column], widths[column])).collect();
            for line in 0..cells.iter().map(Vec::len).max().unwrap_or_default() {
                let cells = cells.iter().zip(&shown).map(|(lines, &column)| {
                    let (cell, width) = (lines.get(line).map_or("", String::as_str), widths[column]);
                    if column < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                });
                text += cells.collect::<Vec<String>>().join("  ").trim_end();
                text.push('\n');
            }
        }
        first += shown.len() - names;
        if columns == names {
            break;
        }
    }
    text
}

/// What the lines of a broken name begin with, but the first.
const INDENT: &str = "  ";

fn length(text: &str) -> usize {
    text.chars().count()
}

/// The pieces of a name between which it may be broken, each with the `+`, `.`, `_` or space that ends it.
fn pieces(name: &str) -> impl Iterator<Item = &str> {
    name.split_inclusive(['+', '.', '_', ' '])
}

/// A name in lines of at most `width` characters; a piece that is longer stands alone.
pub fn broken(name: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for piece in pieces(name) {
        match lines.last_mut() {
            Some(line) if line.is_empty() || length(line) + length(piece.trim_end()) <= width => *line += piece,
            _ => lines.push(format!("{INDENT}{piece}")),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_broken_between_lines_and_none_is_lost() {
        assert_eq!(
            hanging("  dwa  ", 7, "the dynamic window approach", 20),
            "  dwa  the dynamic\n       window\n       approach\n"
        );
        assert_eq!(hanging("", 0, "incomprehensibilities are long", 10), "incomprehensibilities\nare long\n");
        assert_eq!(paragraph("  a b c d e f\ng\n\nnext\n", 7), "  a b c\n  d e f\n  g\n\nnext\n");
        assert_eq!(paragraph("kept as\nit is\n", 80), "kept as\nit is\n");
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_with_its_names() {
        let rows: Vec<Vec<String>> = ["stack time length", "a+b 1 2", "a_star+line_of_sight+dwa 10 20"]
            .map(|row| row.split(' ').map(str::to_owned).collect())
            .to_vec();
        assert_eq!(
            aligned(&rows, 1, WIDE),
            "stack                     time  length\na+b                          1       2\na_star+line_of_sight+dwa    10      20\n"
        );
        assert_eq!(
            aligned(&rows, 1, 26),
            "stack            time\na+b                 1\na_star+line_of_    10\n  sight+dwa\n\n\
             stack            length\na+b                   2\na_star+line_of_      20\n  sight+dwa\n"
        );
    }
}
