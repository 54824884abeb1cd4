//! The colours of every picture, page and plot, in one place.
//!
//! Categories take the eight colours of Okabe and Ito (Color Universal Design, 2008), which the colour-blind can tell apart; each also
//! differs from its neighbours in brightness or comes with a dash or a shape of its own, so that a page printed in grey can be read.

use std::fmt;

/// An opaque colour of the sRGB space. Shown as `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Colour {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

impl Colour {
    /// The colour written `0xrrggbb`.
    pub const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self { r, g, b }
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.r, self.g, self.b)
    }
}

/// The page.
pub const PAPER: Colour = Colour::hex(0xffffff);
/// Text, frames, outlines of the robot.
pub const INK: Colour = Colour::hex(0x22272e);
/// Text of less weight, ticks.
pub const FAINT_INK: Colour = Colour::hex(0x6a727d);
/// Lines of a grid behind data.
pub const GRID_LINE: Colour = Colour::hex(0xe3e5e8);
/// Free cells of a map.
pub const FLOOR: Colour = Colour::hex(0xffffff);
/// Obstacles on the map.
pub const OBSTACLE: Colour = Colour::hex(0x4a5058);
/// Cells that nobody has seen.
pub const UNKNOWN_CELL: Colour = Colour::hex(0xe4e4e1);
/// Obstacles that are not on the map.
pub const NOT_ON_MAP: Colour = ORANGE;
/// Moving obstacles.
pub const MOVER: Colour = PURPLE;
/// Tracks and outlines of moving obstacles.
pub const MOVER_EDGE: Colour = Colour::hex(0x9a4c79);
/// The robot where it is now, or was at the end.
pub const ROBOT: Colour = YELLOW;
/// Planned paths.
pub const PLAN: Colour = BLUE;
/// Goals.
pub const GOAL: Colour = GREEN;
/// What the robot senses.
pub const SENSED: Colour = VERMILION;
/// Contact.
pub const CONTACT: Colour = Colour::hex(0xc4001a);

/// Okabe and Ito's orange.
pub const ORANGE: Colour = Colour::hex(0xe69f00);
/// Okabe and Ito's sky blue.
pub const SKY: Colour = Colour::hex(0x56b4e9);
/// Okabe and Ito's bluish green.
pub const GREEN: Colour = Colour::hex(0x009e73);
/// Okabe and Ito's yellow: too bright for lines on paper.
pub const YELLOW: Colour = Colour::hex(0xf0e442);
/// Okabe and Ito's blue.
pub const BLUE: Colour = Colour::hex(0x0072b2);
/// Okabe and Ito's vermilion.
pub const VERMILION: Colour = Colour::hex(0xd55e00);
/// Okabe and Ito's reddish purple.
pub const PURPLE: Colour = Colour::hex(0xcc79a7);

/// One colour for each of several stacks or curves, in this order; yellow is left out.
pub const SERIES: [Colour; 7] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, INK];

/// Bands for a planner's own states, in the order in which it enters them.
pub const STATES: [Colour; 4] = [ORANGE, SKY, VERMILION, GREEN];

/// From standing (dark) to full speed (bright): eight even steps of viridis, without its yellow end, which is lost on paper.
pub const SPEED: [Colour; 8] = [
    Colour::hex(0x440154),
    Colour::hex(0x472d7b),
    Colour::hex(0x3b528b),
    Colour::hex(0x2c728e),
    Colour::hex(0x21918c),
    Colour::hex(0x28ae80),
    Colour::hex(0x5ec962),
    Colour::hex(0xaddc30),
];

/// The colour of series `index`, starting over after the last.
pub fn series(index: usize) -> Colour {
    SERIES[index % SERIES.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance by WCAG 2.
    fn luminance(colour: Colour) -> f64 {
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { crate::math::exp(2.4 * crate::math::ln((part + 0.055) / 1.055)) }
        };
        0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b)
    }

    #[test]
    fn colours_are_shown_as_pages_write_them() {
        assert_eq!(Colour::hex(0x00_9e_73).to_string(), "#009e73");
    }

    /// In grey print as well the ramp of speeds rises.
    #[test]
    fn faster_is_brighter() {
        assert!(SPEED.windows(2).all(|pair| luminance(pair[0]) < luminance(pair[1])));
    }

    #[test]
    fn text_can_be_read_on_paper() {
        let contrast = |colour| (luminance(PAPER) + 0.05) / (luminance(colour) + 0.05);
        for colour in [INK, FAINT_INK, MOVER_EDGE, CONTACT, PLAN] {
            assert!(contrast(colour) > 4.5, "{colour}: {}", contrast(colour));
        }
    }
}
