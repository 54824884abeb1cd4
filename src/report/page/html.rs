//! Small pieces of HTML.

pub(super) use crate::report::chart::{escape, number};

/// A table whose first `left` columns are text. Heads are escaped here; cells are HTML already.
pub(super) fn table(head: &[String], rows: &[Vec<String>], left: usize, class: &str) -> String {
    let mut text = format!("<div class=\"scroll\" tabindex=\"0\"><table class=\"{class}\"><thead><tr>");
    for (at, cell) in head.iter().enumerate() {
        let kind = if at < left { "" } else { " class=\"n\"" };
        text += &format!("<th scope=\"col\"{kind}>{}</th>", escape(cell));
    }
    text += "</tr></thead><tbody>\n";
    for row in rows {
        text += "<tr>";
        for (at, cell) in row.iter().enumerate() {
            text += &match at {
                0 => format!("<th scope=\"row\">{cell}</th>"),
                at if at < left => format!("<td>{cell}</td>"),
                _ => format!("<td class=\"n\">{cell}</td>"),
            };
        }
        text += "</tr>\n";
    }
    text + "</tbody></table></div>\n"
}

/// A count, its thousands apart.
pub(super) fn count(value: u64) -> String {
    number(value as f64, 0)
}

/// The same, or a dash.
pub(super) fn or_dash(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| number(value, decimals))
}

/// A number with its sign.
pub(super) fn signed(value: f64, decimals: usize) -> String {
    let text = number(value, decimals);
    let is_nothing = !text.bytes().any(|byte| (b'1'..=b'9').contains(&byte));
    if text.starts_with('\u{2212}') || is_nothing { text } else { format!("+{text}") }
}

/// The sentence with its first letter large.
pub(super) fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    let first: String = chars.next().into_iter().flat_map(char::to_uppercase).collect();
    escape(&(first + chars.as_str()))
}

/// A grid of charts, each in a figure with its heading.
pub(super) fn charts(figures: &[(String, String)]) -> String {
    let figures: String = figures
        .iter()
        .map(|(title, svg)| format!("<figure><figcaption>{}</figcaption>\n{svg}</figure>\n", escape(title)))
        .collect();
    if figures.is_empty() { figures } else { format!("<div class=\"charts\">\n{figures}</div>\n") }
}

/// The short form of a p-value.
pub(super) fn p_value(p: f64) -> String {
    if p < 1e-4 { "&lt; 0.0001".to_owned() } else { format!("{p:.4}") }
}
