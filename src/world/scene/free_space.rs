//! Free space of a disc on the true map while obstacles are being placed, in cells.

use crate::geometry::outline::SLACK_M;
use crate::geometry::{Rect, Vec2};
use crate::map::connectivity::{Components, passable};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::world::obstacles::unknown_static::UnknownStatic;
use crate::world::statics::StaticMap;
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

/// Free space on the true map while obstacles are being placed, in cells.
#[derive(Debug)]
pub struct FreeSpace<'a> {
    map: &'a StaticMap,
    /// Cells that are occupied or touched by an unknown static.
    occupied: Cow<'a, [bool]>,
    /// Free space of a disc of the clearance on the known map.
    known: Arc<KnownFreeSpace>,
    /// Cells on which the disc fits now, if that has changed.
    passable: Option<Vec<bool>>,
    clearance_m: f64,
}

impl<'a> FreeSpace<'a> {
    /// The known map.
    pub fn new(map: &'a StaticMap, clearance_m: f64) -> Self {
        let known = map.free_spaces.of(&map.grid, &map.field, clearance_m);
        Self { map, occupied: Cow::Borrowed(map.grid.occupied()), known, passable: None, clearance_m }
    }

    /// The cells.
    pub fn grid(&self) -> &'a OccupancyGrid {
        &self.map.grid
    }

    /// Cells on whose centre the disc fits, row-major.
    pub fn passable(&self) -> &[bool] {
        self.passable.as_deref().unwrap_or(&self.known.passable)
    }

    /// Cells of the known map on whose centre the disc fits, row-major.
    pub fn known(&self) -> &[bool] {
        &self.known.passable
    }

    /// Makes a cell passable unless it is occupied, whether the disc fits there or not.
    pub fn admit(&mut self, cell: Cell) {
        let index = self.map.grid.index(cell);
        let fits = !self.occupied[index];
        if self.passable()[index] != fits {
            self.passable_mut()[index] = fits;
        }
    }

    fn passable_mut(&mut self) -> &mut [bool] {
        self.passable.get_or_insert_with(|| self.known.passable.clone())
    }

    /// The cells that `obstacle` touches.
    pub fn touched(&self, obstacle: &UnknownStatic) -> Vec<Cell> {
        cells_within(&self.map.grid, obstacle.bounds())
            .filter(|&cell| obstacle.touches(self.map.grid.square(cell)))
            .collect()
    }

    /// Adds an obstacle and returns the cells that are no longer passable.
    pub fn add(&mut self, touched: &[Cell]) -> Vec<usize> {
        let grid = self.grid();
        let margin = Vec2::new(self.clearance_m, self.clearance_m);
        let mut blocked = Vec::new();
        for &cell in touched {
            let square = grid.square(cell);
            self.occupied.to_mut()[grid.index(cell)] = true;
            for near in cells_within(grid, Rect { min: square.min - margin, max: square.max + margin }) {
                let index = grid.index(near);
                let distance = square.signed_distance(grid.centre(near));
                if self.passable()[index] && (near == cell || distance < self.clearance_m - SLACK_M) {
                    self.passable_mut()[index] = false;
                    blocked.push(index);
                }
            }
        }
        blocked
    }

    /// Undoes [`Self::add`].
    pub fn remove(&mut self, touched: &[Cell], blocked: &[usize]) {
        let (grid, occupied) = (self.grid(), self.occupied.to_mut());
        for &cell in touched {
            occupied[grid.index(cell)] = false;
        }
        let passable = self.passable_mut();
        for &index in blocked {
            passable[index] = true;
        }
    }

    /// Whether any of the touched cells is occupied already.
    pub fn overlaps(&self, touched: &[Cell]) -> bool {
        touched.iter().any(|&cell| self.occupied[self.map.grid.index(cell)])
    }

    /// Whether any of the touched cells has an occupied cell or the map's edge among its 8 neighbours.
    pub fn adjoins(&self, touched: &[Cell]) -> bool {
        let grid = &self.map.grid;
        touched.iter().any(|cell| {
            (-1..=1).any(|row| {
                (-1..=1).any(|col| {
                    let near = Cell { col: cell.col + col, row: cell.row + row };
                    !grid.contains(near) || self.occupied[grid.index(near)]
                })
            })
        })
    }

    /// Connected components of the passable cells.
    pub fn components(&self) -> Cow<'_, Components> {
        match &self.passable {
            None => Cow::Borrowed(&self.known.components),
            Some(passable) => Cow::Owned(Components::new(self.grid(), passable)),
        }
    }
}

/// The cells of the grid that `rect` meets.
fn cells_within(grid: &OccupancyGrid, rect: Rect) -> impl Iterator<Item = Cell> + use<> {
    let (low, high) = (grid.cell_at(rect.min), grid.cell_at(rect.max));
    let (cols, rows) = (low.col.max(0)..=high.col.min(grid.cols() - 1), low.row.max(0)..=high.row.min(grid.rows() - 1));
    rows.flat_map(move |row| cols.clone().map(move |col| Cell { col, row }))
}

/// Free space of a disc of some clearance on a known map, with its connected components.
#[derive(Debug)]
struct KnownFreeSpace {
    /// Least squared distance of the field at which the disc fits.
    threshold: u32,
    /// The cells on whose centre the disc fits, row-major.
    passable: Vec<bool>,
    /// Connected components of these cells.
    components: Components,
}

/// Cache of the last free-space tables of a map.
#[derive(Clone, Debug, Default)]
pub(in crate::world) struct FreeSpaceCache(Arc<Mutex<Vec<Arc<KnownFreeSpace>>>>);

impl FreeSpaceCache {
    /// Number of tables kept; a scene has two.
    const KEPT: usize = 4;

    /// The free space of a disc of radius `clearance_m` on the map that this cache belongs to.
    fn of(&self, grid: &OccupancyGrid, field: &DistanceField, clearance_m: f64) -> Arc<KnownFreeSpace> {
        let threshold = field.threshold(clearance_m);
        // A table is put in when it is whole, so what a panic has left is as good as any.
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(space) = kept.iter().find(|space| space.threshold == threshold) {
            return Arc::clone(space);
        }
        let passable = passable(field, clearance_m);
        let space = Arc::new(KnownFreeSpace { threshold, components: Components::new(grid, &passable), passable });
        if kept.len() == Self::KEPT {
            kept.remove(0);
        }
        kept.push(Arc::clone(&space));
        space
    }
}
