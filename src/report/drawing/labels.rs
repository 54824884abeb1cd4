//! Small texts beside points of a map, placed so that none lies on another.

use crate::geometry::{Rect, Vec2};
use crate::report::picture::{Anchor, font};

pub(super) struct Labels {
    /// No label leaves it.
    bounds: Rect,
    /// Where nothing more may lie.
    taken: Vec<Rect>,
    /// Points that a label would rather not hide.
    busy: Vec<Vec2>,
}

impl Labels {
    pub fn new(bounds: Rect) -> Self {
        Self { bounds, taken: Vec::new(), busy: Vec::new() }
    }

    /// Keeps labels off a disc about a point.
    pub fn take(&mut self, centre: Vec2, radius: f64) {
        let reach = Vec2::new(radius, radius);
        self.taken.push(Rect { min: centre - reach, max: centre + reach });
    }

    /// Labels would rather not lie on these.
    pub fn avoid(&mut self, points: impl IntoIterator<Item = Vec2>) {
        self.busy.extend(points);
    }

    /// Where a text about `point`, `gap` beside it, begins, is half or ends; `None` if there is no room.
    pub fn place(&mut self, point: Vec2, gap: f64, words: &str, size: f64, bold: bool) -> Option<(Vec2, Anchor)> {
        let (width, height) = (font::width(words, size, bold), 0.74 * size);
        let slant = 0.75 * gap;
        // Right, left, above, below, and between them.
        let places = [
            (Vec2::new(gap, 0.5 * height), Anchor::Start),
            (Vec2::new(slant, -slant), Anchor::Start),
            (Vec2::new(slant, slant + height), Anchor::Start),
            (Vec2::new(-gap, 0.5 * height), Anchor::End),
            (Vec2::new(-slant, -slant), Anchor::End),
            (Vec2::new(-slant, slant + height), Anchor::End),
            (Vec2::new(0.0, -gap), Anchor::Middle),
            (Vec2::new(0.0, gap + height), Anchor::Middle),
        ];
        let candidates = places.into_iter().filter_map(|(by, anchor)| {
            let at = point + by;
            let left = match anchor {
                Anchor::Start => at.x,
                Anchor::Middle => at.x - 0.5 * width,
                Anchor::End => at.x - width,
            };
            let rect = Rect {
                min: Vec2::new(left - 1.5, at.y - height - 1.5),
                max: Vec2::new(left + width + 1.5, at.y + 1.5),
            };
            let is_free = holds(self.bounds, rect.min) && holds(self.bounds, rect.max);
            let is_free = is_free && !self.taken.iter().any(|taken| overlap(taken, &rect));
            let hidden = self.busy.iter().filter(|p| holds(rect, **p)).count();
            is_free.then_some((hidden, at, anchor, rect))
        });
        let (_, at, anchor, rect) = candidates.min_by_key(|(hidden, ..)| *hidden)?;
        self.taken.push(rect);
        Some((at, anchor))
    }
}

fn holds(rect: Rect, p: Vec2) -> bool {
    rect.min.x <= p.x && p.x <= rect.max.x && rect.min.y <= p.y && p.y <= rect.max.y
}

fn overlap(a: &Rect, b: &Rect) -> bool {
    a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels() -> Labels {
        Labels::new(Rect { min: Vec2::zeros(), max: Vec2::new(100.0, 100.0) })
    }

    #[test]
    fn no_label_lies_on_another_or_leaves_the_map() {
        let mut labels = labels();
        let places: Vec<_> =
            (0..20).filter_map(|_| labels.place(Vec2::new(50.0, 50.0), 6.0, "10", 10.0, false)).collect();
        assert!((2..=8).contains(&places.len()), "{}", places.len());
        for (index, a) in labels.taken.iter().enumerate() {
            assert!(labels.taken[..index].iter().all(|b| !overlap(a, b)));
        }
        // At the right edge it goes to the left.
        assert_eq!(
            labels.place(Vec2::new(99.0, 20.0), 6.0, "10", 10.0, false).map(|(_, anchor)| anchor),
            Some(Anchor::End)
        );
    }

    #[test]
    fn a_label_lies_beside_a_track_rather_than_on_it() {
        let mut labels = labels();
        labels.avoid((0..100).map(|x| Vec2::new(f64::from(x), 50.0)));
        let (at, _) = labels.place(Vec2::new(50.0, 50.0), 6.0, "10", 10.0, false).unwrap();
        assert!(at.y < 50.0, "{at}");
    }
}
