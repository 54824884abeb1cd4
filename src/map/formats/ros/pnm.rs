//! What an image of the PNM family (PGM, PPM, PBM, PAM) holds behind its pixels.
//!
//! One byte of white space parts the header from binary pixels. Where a program writes two, as CR LF, every pixel moves on by one and the
//! last byte is left over: the only sign that the map is shifted.

use std::io::{self, BufRead, Read};

/// What is left over, in words: found and expected; `None` if nothing is. The image is one that the decoder has accepted.
pub(super) fn surplus(mut input: impl BufRead) -> io::Result<Option<(String, String)>> {
    let mut magic = [0; 2];
    input.read_exact(&mut magic)?;
    let kind = magic[1];
    let header = if kind == b'7' { named_header(&mut input)? } else { header(&mut input, kind)? };
    let Some(Header { width, height, channels, largest }) = header else { return Ok(None) };
    let bytes = if largest > 255 { 2 } else { 1 };
    let (what, needed) = match kind {
        b'1' => ("digits", width * height),
        b'2' | b'3' => ("numbers", width * height * channels),
        b'4' => ("bytes", width.div_ceil(8) * height),
        _ => ("bytes", width * height * channels * bytes),
    };
    let found = match kind {
        b'1' => count(&mut input, |byte, _| !byte.is_ascii_whitespace())?,
        b'2' | b'3' => count(&mut input, |byte, before| !byte.is_ascii_whitespace() && before.is_ascii_whitespace())?,
        _ => io::copy(&mut input, &mut io::sink())?,
    };
    let said = || (format!("{found} {what} of pixels"), format!("{needed}, as {width} x {height} pixels have"));
    Ok((found > needed).then(said))
}

/// Size and depth of an image.
struct Header {
    width: u64,
    height: u64,
    channels: u64,
    /// Largest value of a channel.
    largest: u64,
}

/// The header of P1 to P6 with the white space that ends it; `None` if it is none.
fn header(input: &mut impl BufRead, kind: u8) -> io::Result<Option<Header>> {
    let mut next = || number(&mut *input);
    let (width, height) = (next()?, next()?);
    let largest = if matches!(kind, b'1' | b'4') { Some(1) } else { next()? };
    let channels = if matches!(kind, b'3' | b'6') { 3 } else { 1 };
    let sizes = width.zip(height).zip(largest);
    Ok(sizes.map(|((width, height), largest)| Header { width, height, channels, largest }))
}

/// The header of P7, a line for each number, with its last line.
fn named_header(input: &mut impl BufRead) -> io::Result<Option<Header>> {
    let [mut width, mut height, mut channels, mut largest] = [None; 4];
    let mut line = Vec::new();
    loop {
        line.clear();
        if Read::by_ref(input).take(LINE_BYTES_MAX).read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_whitespace();
        let key = words.next().unwrap_or_default();
        let mut number = || words.next().and_then(|word| word.parse().ok());
        match key {
            "WIDTH" => width = number(),
            "HEIGHT" => height = number(),
            "DEPTH" => channels = number(),
            "MAXVAL" => largest = number(),
            "ENDHDR" => break,
            _ => {}
        }
    }
    let sizes = width.zip(height).zip(channels.zip(largest));
    Ok(sizes.map(|((width, height), (channels, largest))| Header { width, height, channels, largest }))
}

/// Longest line of a named header that is read, bytes.
const LINE_BYTES_MAX: u64 = 1 << 16;

/// The next number with the one byte of white space behind it; comments and white space in front are passed over. `None` if there is none.
fn number(input: &mut impl BufRead) -> io::Result<Option<u64>> {
    let (mut value, mut is_comment) = (None::<u64>, false);
    loop {
        let Some(&byte) = input.fill_buf()?.first() else { return Ok(value) };
        input.consume(1);
        match byte {
            b'\n' | b'\r' if is_comment => is_comment = false,
            _ if is_comment => {}
            b'#' if value.is_none() => is_comment = true,
            b'0'..=b'9' => {
                let digit = u64::from(byte - b'0');
                value = value.unwrap_or(0).checked_mul(10).and_then(|tens| tens.checked_add(digit));
                if value.is_none() {
                    return Ok(None);
                }
            }
            _ if !byte.is_ascii_whitespace() => return Ok(None),
            _ if value.is_some() => return Ok(value),
            _ => {}
        }
    }
}

/// Bytes that count, given the byte before each.
fn count(input: &mut impl BufRead, counts: impl Fn(u8, u8) -> bool) -> io::Result<u64> {
    let (mut found, mut before) = (0, b' ');
    loop {
        let bytes = input.fill_buf()?;
        if bytes.is_empty() {
            return Ok(found);
        }
        for &byte in bytes {
            found += u64::from(counts(byte, before));
            before = byte;
        }
        let length = bytes.len();
        input.consume(length);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_left_over_is_named() {
        for whole in [
            &b"P5 2 1 255\n12"[..],
            b"P5\n# a comment of 7 pixels\n2 1\n255\n\n\n",
            b"P5\r\n2 1\r\n255\n12",
            b"P5 2 1 65535\n1234",
            b"P6 2 1 255\n123456",
            b"P4 9 2\n1234",
            b"P2 2 1 255 0 12\n",
            b"P2\n2 1\n255\n0\t12 \r\n",
            b"P3 1 1 255 0 12 1",
            b"P1 3 1 0 1 1\n",
            b"P1 3 1 011\n",
            b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n12",
            // Fewer than needed are for the decoder to refuse.
            b"P5 2 2 255\n12",
        ] {
            assert_eq!(surplus(whole).unwrap(), None, "{}", whole.escape_ascii());
        }
        for (bytes, expected) in [
            (&b"P5\r\n2 1\r\n255\r\n12"[..], "3 bytes of pixels"),
            (b"P5 2 1 255 \n12", "3 bytes of pixels"),
            (b"P5 2 1 255\n12\n", "3 bytes of pixels"),
            (b"P5 2 1 255\n12P5 2 1 255\n12", "15 bytes of pixels"),
            (b"P6 2 1 255\n1234567", "7 bytes of pixels"),
            (b"P4 9 2\n12345", "5 bytes of pixels"),
            (b"P2 2 1 255 0 12 13", "3 numbers of pixels"),
            (b"P1 3 1 0111", "4 digits of pixels"),
            (b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\nENDHDR\n123", "3 bytes of pixels"),
        ] {
            let (found, wanted) = surplus(bytes).unwrap().unwrap();
            assert_eq!(found, expected, "{}", bytes.escape_ascii());
            assert!(wanted.contains(" pixels have"), "{wanted}");
        }
    }
}
