//! Values as the text of one field of a table, and back.

use super::field::Field;
use crate::digest::Digest;
use crate::math;
use std::borrow::Cow;
use std::fmt::Write as _;

/// A value as the text of one field.
pub(super) trait Value {
    /// Appends the text.
    fn write(&self, out: &mut String);
    /// Takes the value of a text; the error says what was expected.
    fn read(&mut self, text: &str) -> Result<(), &'static str>;
    /// The value with its type.
    fn field(&self) -> Field;
    /// The value as a number, for statistics.
    fn number(&self) -> Option<f64> {
        None
    }
}

impl Value for String {
    fn write(&self, out: &mut String) {
        out.push_str(&one_line(self));
    }

    fn read(&mut self, text: &str) -> Result<(), &'static str> {
        text.clone_into(self);
        Ok(())
    }

    fn field(&self) -> Field {
        self.into()
    }
}

macro_rules! whole_values {
    ($($int:ty),*) => {$(
        impl Value for $int {
            fn write(&self, out: &mut String) {
                write!(out, "{self}").expect("writing to a string cannot fail");
            }

            fn read(&mut self, text: &str) -> Result<(), &'static str> {
                *self = text.parse().map_err(|_| "a whole number")?;
                Ok(())
            }

            fn field(&self) -> Field {
                (*self).into()
            }

            fn number(&self) -> Option<f64> {
                Some(*self as f64)
            }
        }
    )*};
}
whole_values!(u32, u64);

impl Value for f64 {
    fn write(&self, out: &mut String) {
        write!(out, "{}", math::canonical(*self)).expect("writing to a string cannot fail");
    }

    fn read(&mut self, text: &str) -> Result<(), &'static str> {
        *self = text.parse().ok().filter(|x: &f64| x.is_finite()).map(math::canonical).ok_or("a finite number")?;
        Ok(())
    }

    fn field(&self) -> Field {
        (*self).into()
    }

    fn number(&self) -> Option<f64> {
        Some(*self)
    }
}

impl Value for Digest {
    fn write(&self, out: &mut String) {
        write!(out, "{self}").expect("writing to a string cannot fail");
    }

    fn read(&mut self, text: &str) -> Result<(), &'static str> {
        let digits = text.len() == 16 && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
        let value = digits.then(|| u64::from_str_radix(text, 16).ok()).flatten();
        *self = Self(value.ok_or("16 hexadecimal digits")?);
        Ok(())
    }

    fn field(&self) -> Field {
        (&self.to_string()).into()
    }
}

impl<V: Value + Default> Value for Option<V> {
    fn write(&self, out: &mut String) {
        if let Some(value) = self {
            value.write(out);
        }
    }

    fn read(&mut self, text: &str) -> Result<(), &'static str> {
        *self = if text.is_empty() {
            None
        } else {
            let mut value = V::default();
            value.read(text)?;
            Some(value)
        };
        Ok(())
    }

    fn field(&self) -> Field {
        self.as_ref().map_or(Field::Empty, Value::field)
    }

    fn number(&self) -> Option<f64> {
        self.as_ref().and_then(Value::number)
    }
}

/// `text` with a space in place of every control character, so that a row stays one line.
pub(super) fn one_line(text: &str) -> Cow<'_, str> {
    if text.contains(char::is_control) { Cow::Owned(text.replace(char::is_control, " ")) } else { Cow::Borrowed(text) }
}
