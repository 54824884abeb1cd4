//! Commands to copy: words as a shell reads them.

use std::ffi::OsStr;

/// Words as one line that a shell parts into the same words.
pub fn line<W: AsRef<OsStr>>(words: impl IntoIterator<Item = W>) -> String {
    words.into_iter().map(quoted).collect::<Vec<String>>().join(" ")
}

/// One word, in quotes if a shell would read it otherwise. What a terminal would act on is written as bash takes it, `$'…'`.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-+=:,./@%".contains(c);
    match word.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(is_plain) => text.to_owned(),
        Some(text) if !text.chars().any(char::is_control) => format!("'{}'", text.replace('\'', r"'\''")),
        // What a terminal would act on, or cannot show.
        _ => {
            let bytes = word.as_encoded_bytes().iter().map(|&byte| match byte {
                b'\'' | b'\\' => format!("\\{}", char::from(byte)),
                b' '..=b'~' => char::from(byte).to_string(),
                // Three digits: a digit that follows is none of it.
                _ => format!("\\{byte:03o}"),
            });
            format!("$'{}'", bytes.collect::<String>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_same_words() {
        let words = [
            "simrun",
            "--set",
            "goal=[8, 3]",
            "",
            "it's",
            "a b",
            "$HOME",
            "~",
            "*",
            "é",
            "back\\slash",
            "new\nline",
            "\u{1b}[31m7",
            "-o=x;y",
        ];
        let line = line(words);
        assert!(!line.contains(char::is_control), "{line}");
        // printf ends each word with a NUL, which no word holds.
        let answer = std::process::Command::new("bash").args(["-c", &format!("printf '%s\\0' {line}")]).output();
        // Not every system has one.
        let Ok(answer) = answer else { return };
        let read = String::from_utf8(answer.stdout).unwrap();
        assert_eq!(read.split_terminator('\0').collect::<Vec<_>>(), words);
        assert!(line.starts_with("simrun --set 'goal=[8, 3]' '' 'it'\\''s' "), "{line}");
    }
}
