//! The regions: parts of the path, each with a rectangle about its chord.

use super::{Params, Split};
use crate::geometry::Vec2;
use crate::geometry::convex;
use crate::plan::contract::Guidance;

/// Shapes nearer than this touch, m: the edges of regions along a grid lie on those of its cells.
const TOUCH_M: f64 = 1e-9;

/// One region.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Region {
    /// Arc lengths between which it lies, m.
    from_m: f64,
    to_m: f64,
    /// The ends of its axis.
    ends: [Vec2; 2],
    rectangle: Rectangle,
}

/// A rectangle about an axis, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    corners: [Vec2; 4],
}

impl Rectangle {
    fn about(from: Vec2, to: Vec2, overlap_m: f64, half_width_m: f64) -> Self {
        let length_m = (to - from).norm();
        let along = if length_m > 0.0 { (to - from) / length_m } else { Vec2::new(1.0, 0.0) };
        let across = Vec2::new(-along.y, along.x) * half_width_m;
        let (begin, end) = (from - along * overlap_m, to + along * overlap_m);
        Self { corners: [begin - across, end - across, end + across, begin + across] }
    }

    /// Whether a disc touches it.
    pub(super) fn touches_disc(&self, centre: Vec2, radius_m: f64) -> bool {
        convex::point_distance(&self.corners, centre) <= radius_m + TOUCH_M
    }

    /// Whether a convex polygon touches it.
    pub(super) fn touches(&self, corners: &[Vec2]) -> bool {
        convex::distance(&self.corners, corners) <= TOUCH_M
    }
}

/// The regions of the path in force, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Regions {
    regions: Vec<Region>,
    cuts_m: Vec<f64>,
    path_revision: Option<u32>,
    overlap_m: f64,
}

impl Regions {
    pub(super) fn clear(&mut self) {
        self.regions.clear();
        self.path_revision = None;
    }

    /// Cuts the path anew if another one is in force; whether it did.
    pub(super) fn follow(&mut self, guidance: &Guidance<'_>, params: &Params) -> bool {
        if self.path_revision == Some(guidance.path_revision) {
            return false;
        }
        self.path_revision = Some(guidance.path_revision);
        self.overlap_m = params.region_overlap_m.get();
        let path = guidance.path;
        self.cuts_m.clear();
        self.cuts_m.extend(guidance.key_nodes.iter().map(|node| node.along_m));
        if self.cuts_m.len() < 2 {
            self.cuts_m.clear();
            self.cuts_m.extend([0.0, path.length()]);
        }
        if params.split == Split::Length {
            let (longest_m, shortest_m) = (params.region_length_max_m.get(), params.region_length_min_m.get());
            self.cut(longest_m);
            self.join(shortest_m);
        }
        self.regions.clear();
        self.regions.extend(self.cuts_m.windows(2).map(|cut| {
            let ends = [path.point_at(cut[0]), path.point_at(cut[1])];
            let [from, to] = ends;
            let rectangle = Rectangle::about(from, to, self.overlap_m, params.region_half_width_m.get());
            Region { from_m: cut[0], to_m: cut[1], ends, rectangle }
        }));
        true
    }

    /// Cuts what is longer than `longest_m` into equal parts.
    fn cut(&mut self, longest_m: f64) {
        let whole = core::mem::take(&mut self.cuts_m);
        self.cuts_m.push(whole[0]);
        for pair in whole.windows(2) {
            let length_m = pair[1] - pair[0];
            let parts = (length_m / longest_m).ceil().clamp(1.0, 1e6) as u32;
            for part in 1..parts {
                self.cuts_m.push(pair[0] + length_m * f64::from(part) / f64::from(parts));
            }
            self.cuts_m.push(pair[1]);
        }
    }

    /// Joins what is shorter than `shortest_m` with the next one, the last one with the one before.
    fn join(&mut self, shortest_m: f64) {
        let mut kept = 1;
        for at in 1..self.cuts_m.len() {
            if self.cuts_m[at] - self.cuts_m[kept - 1] >= shortest_m {
                self.cuts_m[kept] = self.cuts_m[at];
                kept += 1;
            }
        }
        let end_m = self.cuts_m[self.cuts_m.len() - 1];
        self.cuts_m.truncate(kept.max(2));
        let last = self.cuts_m.len() - 1;
        self.cuts_m[last] = end_m;
    }

    /// Number of the region in which a robot at an arc length is: the last one that it has entered, overlap included.
    pub(super) fn at(&self, along_m: f64) -> usize {
        let entered_m = along_m + self.overlap_m;
        self.regions.partition_point(|region| region.to_m <= entered_m).min(self.regions.len() - 1)
    }

    /// Whether `region` is the last one.
    pub(super) fn is_last(&self, region: usize) -> bool {
        region + 1 == self.regions.len()
    }

    /// Arc length at which a region begins, m.
    pub(super) fn begin_m(&self, region: usize) -> f64 {
        self.regions[region].from_m
    }

    /// Both ends of a region's axis.
    pub(super) fn ends(&self, region: usize) -> (Vec2, Vec2) {
        let [from, to] = self.regions[region].ends;
        (from, to)
    }

    /// The rectangles from region `first` to region `last`, both included.
    pub(super) fn rectangles(&self, first: usize, last: usize) -> impl Iterator<Item = &Rectangle> + Clone {
        self.regions[first..=last].iter().map(|region| &region.rectangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{KeyNode, Path};
    use crate::settings::quantity::{NonNegative, Positive};

    /// Lengths of the regions of a straight path with key nodes at these arc lengths.
    fn lengths(nodes: &[f64], params: &Params) -> Vec<f64> {
        let path = Path::polyline(&[Vec2::new(0.0, 0.0), Vec2::new(*nodes.last().unwrap(), 0.0)]);
        let node = |&along_m: &f64| KeyNode { position: Vec2::new(along_m, 0.0), along_m };
        let nodes: Vec<KeyNode> = nodes.iter().map(node).collect();
        let guidance = Guidance { key_nodes: &nodes, ..Guidance::to_end(&path, 0.0) };
        let mut regions = Regions::default();
        assert!(regions.follow(&guidance, params) && !regions.follow(&guidance, params));
        regions.regions.iter().map(|region| region.to_m - region.from_m).collect()
    }

    #[test]
    fn regions_end_at_turning_points_or_are_neither_long_nor_short() {
        let printed = Params { split: Split::TurningPoints, ..Params::default() };
        let nodes = [0.0, 1.0, 11.0, 11.5, 14.0, 15.0];
        assert_eq!(lengths(&nodes, &printed), [1.0, 10.0, 0.5, 2.5, 1.0]);
        // 1 + 5, 5, 0.5 + 2.5 + 1 (the last one is too short).
        assert_eq!(lengths(&nodes, &Params::default()), [6.0, 5.0, 4.0]);
        assert_eq!(lengths(&[0.0, 1.0], &Params::default()), [1.0]);
        assert_eq!(lengths(&[0.0, 0.0], &Params::default()), [0.0]);
        assert_eq!(lengths(&[0.0, 24.0], &Params::default()), [8.0, 8.0, 8.0]);
    }

    #[test]
    fn a_rectangle_is_as_wide_and_as_long_as_it_should_be() {
        let params = Params {
            region_half_width_m: Positive::new(1.0),
            region_overlap_m: NonNegative::new(0.5),
            ..Params::default()
        };
        let path = Path::polyline(&[Vec2::new(1.0, 1.0), Vec2::new(1.0, 6.0)]);
        let mut regions = Regions::default();
        regions.follow(&Guidance::to_end(&path, 0.0), &params);
        let rectangle = *regions.rectangles(0, 0).next().unwrap();
        // From (0, 0.5) to (2, 6.5).
        assert!(rectangle.touches_disc(Vec2::new(3.0, 3.0), 1.0) && !rectangle.touches_disc(Vec2::new(3.0, 3.0), 0.99));
        // 3-4-5 from the corner.
        assert!(rectangle.touches_disc(Vec2::new(5.0, 10.5), 5.001));
        assert!(!rectangle.touches_disc(Vec2::new(5.0, 10.5), 4.999));
        let square =
            |x: f64, y: f64| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(a, b)| Vec2::new(x + a, y + b));
        assert!(rectangle.touches(&square(1.9, 2.0)) && !rectangle.touches(&square(2.1, 2.0)));
    }

    #[test]
    fn the_robot_is_in_the_next_region_as_soon_as_it_enters_its_rectangle() {
        let path = Path::polyline(&[Vec2::new(0.0, 0.0), Vec2::new(24.0, 0.0)]);
        let mut regions = Regions::default();
        regions.follow(&Guidance::to_end(&path, 0.0), &Params::default());
        let at: Vec<usize> = [0.0, 7.4, 7.5, 16.5, 24.0].iter().map(|&along_m| regions.at(along_m)).collect();
        assert_eq!(at, [0, 0, 1, 2, 2]);
    }
}
