//! All that a planner may know at a tick. Nothing else exists for it.

use crate::geometry::outline::Outline;
use crate::geometry::{Pose, Rect, Twist, Vec2};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::robot::Robot;

/// The map as the robot believes it: the known map plus the unknown statics seen so far.
#[derive(Clone, Debug)]
pub struct Belief {
    grid: OccupancyGrid,
    field: DistanceField,
    revision: u64,
    added: Vec<Cell>,
}

impl Belief {
    /// The belief before anything was seen.
    pub fn new(grid: &OccupancyGrid, field: &DistanceField) -> Self {
        Self { grid: grid.clone(), field: field.clone(), revision: 0, added: Vec::new() }
    }

    /// Marks every cell that `touches` says an obstacle touches, within `bounds` (grid frame).
    pub fn add(&mut self, bounds: Rect, touches: impl Fn(Rect) -> bool) {
        let first = self.grid.cell_at(bounds.min);
        let last = self.grid.cell_at(bounds.max);
        let before = self.added.len();
        for row in first.row.max(0)..=last.row.min(self.grid.rows() - 1) {
            for col in first.col.max(0)..=last.col.min(self.grid.cols() - 1) {
                let cell = Cell { col, row };
                if self.grid.is_free(cell) && touches(self.grid.square(cell)) {
                    self.grid.set_occupied(cell);
                    self.added.push(cell);
                }
            }
        }
        if self.added.len() > before {
            self.field.add(&self.grid, &self.added[before..]);
            self.revision += 1;
        }
    }

    /// Frees the cells within `bounds` (grid frame) that were added for an obstacle that touches what `touches` says, but for those
    /// that `still_touched` claims for others.
    pub fn remove(&mut self, bounds: Rect, touches: impl Fn(Rect) -> bool, still_touched: impl Fn(Rect) -> bool) {
        let Self { grid, added, .. } = self;
        let before = added.len();
        added.retain(|&cell| {
            let square = grid.square(cell);
            let overlaps = square.min.x <= bounds.max.x
                && square.max.x >= bounds.min.x
                && square.min.y <= bounds.max.y
                && square.max.y >= bounds.min.y;
            let stays = !overlaps || !touches(square) || still_touched(square);
            if !stays {
                grid.set_free(cell);
            }
            stays
        });
        if added.len() < before {
            // Distances grow again, which cannot be done cell by cell; it happens rarely.
            self.field = DistanceField::new(&self.grid);
            self.revision += 1;
        }
    }

    /// Occupancy as believed.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Exact distance field of [`Self::grid`].
    pub fn field(&self) -> &DistanceField {
        &self.field
    }

    /// Counts the changes: equal revisions mean an equal map.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Cells that were added to the known map, oldest first.
    pub fn added(&self) -> &[Cell] {
        &self.added
    }
}

/// A moving obstacle as sensed.
#[derive(Clone, Debug, PartialEq)]
pub struct SensedObstacle {
    /// Centre, grid frame, metres.
    pub position: Vec2,
    /// Velocity, m/s.
    pub velocity: Vec2,
    /// Its outline about that centre.
    pub outline: Outline,
}

impl SensedObstacle {
    /// A disc.
    pub fn disc(position: Vec2, velocity: Vec2, radius_m: f64) -> Self {
        Self { position, velocity, outline: Outline::disc(radius_m) }
    }

    /// Radius of the smallest disc about its centre that holds it, m.
    pub fn radius_m(&self) -> f64 {
        self.outline.circumradius_m()
    }
}

/// What a scanner at the robot's centre measured. Ray i points at heading + `bearing_first_rad` + i `bearing_step_rad`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan<'a> {
    /// Bearing of ray 0, rad, counter-clockwise from the heading.
    pub bearing_first_rad: f64,
    /// From one ray to the next, rad.
    pub bearing_step_rad: f64,
    /// Distance along each ray, m; infinity where nothing came back.
    pub ranges_m: &'a [f64],
}

/// What the robot knows at one tick. Positions are in the grid frame (origin at the map's lower left corner).
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// The tick, counted from 0; time is `tick * dt_s`.
    pub tick: u32,
    /// Control period, s.
    pub dt_s: f64,
    /// Own pose as believed.
    pub pose: Pose,
    /// Own twist as believed.
    pub twist: Twist,
    /// The map as believed.
    pub belief: &'a Belief,
    /// Moving obstacles in sensor range, in the order of the scenario.
    pub obstacles: &'a [SensedObstacle],
    /// What the scanner measured, if the robot has one.
    pub scan: Option<Scan<'a>>,
    /// Where the robot is to go.
    pub goal: Vec2,
    /// The robot itself: footprint and limits.
    pub robot: &'a Robot,
}

impl Observation<'_> {
    /// Simulated time since `tick`, s.
    pub fn time_since_s(&self, tick: u32) -> f64 {
        f64::from(self.tick - tick) * self.dt_s
    }
}
