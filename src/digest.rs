//! Digests of 64 bits: their value, and the hash for everything that has no faster one of its own.

use crate::geometry::Vec2;
use crate::math;
use std::fmt;

/// A digest of 64 bits, written as 16 hexadecimal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Digest {
    /// The FNV-1a hash of bytes.
    pub fn of(bytes: &[u8]) -> Self {
        let mut hash = Fnv1a::default();
        hash.bytes(bytes);
        Self(hash.value())
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// A running FNV-1a hash of 64 bits (Fowler, Noll, Vo). No defence against somebody who looks for two equal ones.
#[derive(Clone, Copy, Debug)]
pub struct Fnv1a(u64);

impl Default for Fnv1a {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv1a {
    /// Takes in bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Takes in a word, its lowest byte first.
    pub fn word(&mut self, word: u64) {
        self.bytes(&word.to_le_bytes());
    }

    /// Takes in words in order.
    pub fn words<const N: usize>(&mut self, words: [u64; N]) {
        words.into_iter().for_each(|word| self.word(word));
    }

    /// Takes in the bits of a number; 0 and −0 are the same.
    ///
    /// # Panics
    /// If it is not finite.
    pub fn real(&mut self, number: f64) {
        self.word(math::canonical(number).to_bits());
    }

    /// Takes in both coordinates of a point.
    pub fn point(&mut self, p: Vec2) {
        self.real(p.x);
        self.real(p.y);
    }

    /// The hash of everything taken in.
    pub fn value(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv_1a() {
        // Vectors of the authors' reference (draft-eastlake-fnv).
        for (text, expected) in [("", "cbf29ce484222325"), ("a", "af63dc4c8601ec8c"), ("foobar", "85944171f73967e8")] {
            assert_eq!(Digest::of(text.as_bytes()).to_string(), expected, "{text}");
        }
    }

    #[test]
    fn words_reals_and_points_are_their_bytes() {
        let mut whole = Fnv1a::default();
        whole.bytes(&[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0]);
        let mut parts = Fnv1a::default();
        parts.words([1]);
        parts.point(Vec2::new(1.0, -0.0));
        assert_eq!(parts.value(), whole.value());
    }
}
