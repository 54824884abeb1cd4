//! The robot's knowledge of its world: the believed map, the sensed movers, the scan.

use crate::geometry::outline::Outline;
use crate::geometry::{Rect, Vec2};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The map as the robot believes it: the known map plus the unknown statics seen so far. It shares the known map with
/// others until it differs from it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "BeliefBytes", into = "BeliefBytes")]
pub struct Belief {
    known: (Arc<OccupancyGrid>, Arc<DistanceField>),
    /// The believed map once it differs from the known one; otherwise a buffer kept for reuse.
    own: Option<(OccupancyGrid, DistanceField)>,
    differs: bool,
    revision: u64,
    added: Vec<Cell>,
}

impl Belief {
    /// The belief before anything was seen; `field` is that of `grid`.
    pub fn new(grid: &Arc<OccupancyGrid>, field: &Arc<DistanceField>) -> Self {
        let known = (Arc::clone(grid), Arc::clone(field));
        Self { known, own: None, differs: false, revision: 0, added: Vec::new() }
    }

    /// Forgets everything seen and begins with another known map. Buffers are reused.
    pub fn begin(&mut self, grid: &Arc<OccupancyGrid>, field: &Arc<DistanceField>) {
        self.known = (Arc::clone(grid), Arc::clone(field));
        self.differs = false;
        self.revision = 0;
        self.added.clear();
    }

    /// Becomes a copy of `other`. Buffers are reused.
    pub fn copy_from(&mut self, other: &Self) {
        let Self { known, own, differs, revision, added } = other;
        self.known.clone_from(known);
        if let (true, Some(theirs)) = (*differs, own) {
            match &mut self.own {
                Some(ours) => {
                    ours.0.clone_from(&theirs.0);
                    ours.1.clone_from(&theirs.1);
                }
                ours => *ours = Some(theirs.clone()),
            }
        }
        (self.differs, self.revision) = (*differs, *revision);
        self.added.clone_from(added);
    }

    /// Marks the cells within `bounds` (grid frame) that an obstacle touches according to `touches`.
    pub fn add(&mut self, bounds: Rect, touches: impl Fn(Rect) -> bool) {
        let grid = self.grid();
        let (first, last) = (grid.cell_at(bounds.min), grid.cell_at(bounds.max));
        let (cols, rows) = (grid.cols(), grid.rows());
        let before = self.added.len();
        for row in first.row.max(0)..=last.row.min(rows - 1) {
            for col in first.col.max(0)..=last.col.min(cols - 1) {
                let cell = Cell { col, row };
                if self.grid().is_free(cell) && touches(self.grid().square(cell)) {
                    self.own().0.set_occupied(cell);
                    self.added.push(cell);
                }
            }
        }
        if self.added.len() > before {
            let added = core::mem::take(&mut self.added);
            let (grid, field) = self.own();
            field.add(grid, &added[before..]);
            self.added = added;
            self.revision += 1;
        }
    }

    /// Frees the added cells within `bounds` (grid frame) that the vanished obstacle touches (`touches`), except those that
    /// another known obstacle still touches (`still_touched`).
    pub fn remove(&mut self, bounds: Rect, touches: impl Fn(Rect) -> bool, still_touched: impl Fn(Rect) -> bool) {
        let before = self.added.len();
        let mut added = core::mem::take(&mut self.added);
        let (grid, field) = self.own();
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
            *field = DistanceField::new(grid);
            self.revision += 1;
        }
        self.added = added;
    }

    /// Grid and field of its own.
    fn own(&mut self) -> &mut (OccupancyGrid, DistanceField) {
        let (grid, field) = &self.known;
        let own = self.own.get_or_insert_with(|| (OccupancyGrid::clone(grid), DistanceField::clone(field)));
        if !core::mem::replace(&mut self.differs, true) {
            own.0.clone_from(grid);
            own.1.clone_from(field);
        }
        own
    }

    /// Occupancy as believed.
    pub fn grid(&self) -> &OccupancyGrid {
        match &self.own {
            Some((grid, _)) if self.differs => grid,
            _ => &self.known.0,
        }
    }

    /// Exact distance field of [`Self::grid`].
    pub fn field(&self) -> &DistanceField {
        match &self.own {
            Some((_, field)) if self.differs => field,
            _ => &self.known.1,
        }
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

impl PartialEq for Belief {
    fn eq(&self, other: &Self) -> bool {
        let parts = |belief: &Self| (belief.revision, belief.differs);
        parts(self) == parts(other) && self.known.0 == other.known.0 && self.added == other.added
    }
}

/// A belief as it is written, without the parts that follow from the rest.
#[derive(Serialize, Deserialize)]
struct BeliefBytes {
    known: OccupancyGrid,
    added: Vec<Cell>,
    differs: bool,
    revision: u64,
}

impl From<Belief> for BeliefBytes {
    fn from(belief: Belief) -> Self {
        let Belief { known, differs, revision, added, .. } = belief;
        Self { known: OccupancyGrid::clone(&known.0), added, differs, revision }
    }
}

impl From<BeliefBytes> for Belief {
    fn from(bytes: BeliefBytes) -> Self {
        let mut belief = Self::from(&bytes.known);
        if bytes.differs {
            let (grid, field) = belief.own();
            for &cell in bytes.added.iter().filter(|&&cell| bytes.known.contains(cell)) {
                grid.set_occupied(cell);
            }
            *field = DistanceField::new(grid);
        }
        Self { added: bytes.added, revision: bytes.revision, ..belief }
    }
}

impl From<&OccupancyGrid> for Belief {
    /// The belief before anything was seen, for a map whose distance field is computed here.
    fn from(grid: &OccupancyGrid) -> Self {
        Self::new(&Arc::new(grid.clone()), &Arc::new(DistanceField::new(grid)))
    }
}

/// A moving obstacle as sensed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensedObstacle {
    /// Number of the mover in the scene: the same from tick to tick.
    pub id: u32,
    /// Centre, grid frame, metres.
    pub position: Vec2,
    /// Velocity, m/s.
    pub velocity: Vec2,
    /// Its outline about that centre.
    pub outline: Outline,
}

impl SensedObstacle {
    /// A disc.
    pub fn disc(id: u32, position: Vec2, velocity: Vec2, radius_m: f64) -> Self {
        Self { id, position, velocity, outline: Outline::disc(radius_m) }
    }

    /// Radius of the smallest disc about its centre that holds it, m.
    pub fn radius_m(&self) -> f64 {
        self.outline.circumradius_m()
    }
}

/// A scan from the robot's centre. Ray i points at heading + `bearing_first_rad` + i `bearing_step_rad`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan<'a> {
    /// Bearing of ray 0, rad, counter-clockwise from the heading.
    pub bearing_first_rad: f64,
    /// Step of the bearing from one ray to the next, rad.
    pub bearing_step_rad: f64,
    /// Distance along each ray, m; infinity where nothing came back.
    pub ranges_m: &'a [f64],
}
