//! Detail of an episode recorded in full, beside its trace: sensed obstacles and the believed map.

use crate::map::Cell;
use crate::observation::{Belief, SensedObstacle};

/// Sensed obstacles and changes of the believed map, tick by tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detail {
    /// Sensed obstacles, one tick after the other.
    sensed: Vec<SensedObstacle>,
    /// End of each tick's part of `sensed`.
    sensed_ends: Vec<usize>,
    /// Every change of the belief map, oldest first.
    pub belief: Vec<BeliefChange>,
    /// The cells added to the known map after the last change.
    believed: Vec<Cell>,
    revision: u64,
}

/// A change of the belief map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BeliefChange {
    /// The tick at whose beginning it was sensed.
    pub tick: u32,
    /// Cells that were taken to be occupied, in order of column, then row.
    pub entered: Vec<Cell>,
    /// Cells that were taken to be free again, in the same order.
    pub left: Vec<Cell>,
}

impl Detail {
    /// Notes the sensed obstacles and the belief of a tick. Must be called at every tick from 0 on.
    pub fn note(&mut self, tick: u32, belief: &Belief, sensed: &[SensedObstacle]) {
        self.sensed.extend_from_slice(sensed);
        self.sensed_ends.push(self.sensed.len());
        if belief.revision() == self.revision {
            return;
        }
        self.revision = belief.revision();
        let mut now = belief.added().to_vec();
        now.sort_unstable();
        let beyond = |these: &[Cell], those: &[Cell]| -> Vec<Cell> {
            these.iter().filter(|cell| those.binary_search(cell).is_err()).copied().collect()
        };
        let (entered, left) = (beyond(&now, &self.believed), beyond(&self.believed, &now));
        self.belief.push(BeliefChange { tick, entered, left });
        self.believed = now;
    }

    /// Number of ticks noted so far.
    pub fn ticks(&self) -> usize {
        self.sensed_ends.len()
    }

    /// Obstacles sensed at the beginning of `tick`.
    pub fn sensed_at(&self, tick: usize) -> &[SensedObstacle] {
        let begin = if tick == 0 { 0 } else { self.sensed_ends[tick - 1] };
        &self.sensed[begin..self.sensed_ends[tick]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Rect, Vec2};
    use crate::map::OccupancyGrid;

    #[test]
    fn cells_that_enter_and_leave_the_belief_add_up_to_it() {
        let mut belief = Belief::from(&OccupancyGrid::empty(9, 9, 1.0));
        let mut detail = Detail::default();
        let square = |x: f64, y: f64| Rect { min: Vec2::new(x, y), max: Vec2::new(x + 0.5, y + 0.5) };
        let mover = SensedObstacle::disc(3, Vec2::new(1.0, 1.0), Vec2::zeros(), 0.3);
        detail.note(0, &belief, &[]);
        belief.add(square(2.2, 3.2), |_| true);
        belief.add(square(5.2, 3.2), |_| true);
        detail.note(1, &belief, core::slice::from_ref(&mover));
        detail.note(2, &belief, &[]);
        belief.remove(square(2.2, 3.2), |_| true, |_| false);
        detail.note(3, &belief, &[]);
        let cell = |col, row| Cell { col, row };
        let expected = [
            BeliefChange { tick: 1, entered: vec![cell(2, 3), cell(5, 3)], left: vec![] },
            BeliefChange { tick: 3, entered: vec![], left: vec![cell(2, 3)] },
        ];
        assert_eq!(detail.belief, expected);
        assert_eq!((detail.ticks(), detail.sensed_at(0), detail.sensed_at(1)), (4, &[][..], &[mover][..]));
    }
}
