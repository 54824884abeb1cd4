//! Everything that the robot can touch, in one order: the known map with its edge, the unknown statics, the movers.

/// Something that the robot can touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::world) enum Body {
    /// The known map with its edge.
    Map,
    /// An unknown static, by its number in the scene.
    Unknown(usize),
    /// A mover, by its number in the scene.
    Mover(usize),
}

/// Number of bodies of each sort in a scene.
#[derive(Clone, Copy, Debug)]
pub(in crate::world) struct Bodies {
    /// Number of unknown statics.
    pub(in crate::world) unknown: usize,
    /// Number of movers.
    pub(in crate::world) movers: usize,
}

impl Bodies {
    /// Number of all bodies, the map included.
    pub(in crate::world) fn count(self) -> usize {
        1 + self.unknown + self.movers
    }

    /// All of them, in their order.
    pub(in crate::world) fn iter(self) -> impl Iterator<Item = Body> {
        let unknown = (0..self.unknown).map(Body::Unknown);
        core::iter::once(Body::Map).chain(unknown).chain((0..self.movers).map(Body::Mover))
    }

    /// The place of a body in that order.
    pub(in crate::world) fn index(self, body: Body) -> usize {
        match body {
            Body::Map => 0,
            Body::Unknown(number) => 1 + number,
            Body::Mover(number) => 1 + self.unknown + number,
        }
    }
}

/// A value for each body.
#[derive(Clone, Debug)]
pub(in crate::world) struct PerBody<T> {
    bodies: Bodies,
    values: Vec<T>,
}

impl<T: Clone> PerBody<T> {
    /// The same value for every body.
    pub(in crate::world) fn new(bodies: Bodies, value: T) -> Self {
        Self { bodies, values: vec![value; bodies.count()] }
    }

    /// Each body with its value, in their order.
    pub(in crate::world) fn iter(&self) -> impl Iterator<Item = (Body, &T)> {
        self.bodies.iter().zip(&self.values)
    }

    /// Each body with its value, to change it.
    pub(in crate::world) fn iter_mut(&mut self) -> impl Iterator<Item = (Body, &mut T)> {
        self.bodies.iter().zip(&mut self.values)
    }
}

impl<T> core::ops::Index<Body> for PerBody<T> {
    type Output = T;

    fn index(&self, body: Body) -> &T {
        &self.values[self.bodies.index(body)]
    }
}

impl<T> core::ops::IndexMut<Body> for PerBody<T> {
    fn index_mut(&mut self, body: Body) -> &mut T {
        &mut self.values[self.bodies.index(body)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_body_has_one_place_in_the_order() {
        for (unknown, movers) in [(0, 0), (3, 0), (0, 2), (3, 2)] {
            let bodies = Bodies { unknown, movers };
            let places: Vec<usize> = bodies.iter().map(|body| bodies.index(body)).collect();
            assert_eq!(places, (0..bodies.count()).collect::<Vec<_>>());
            assert_eq!(bodies.count(), 1 + unknown + movers);
        }
        let bodies = Bodies { unknown: 3, movers: 2 };
        assert_eq!(bodies.iter().nth(4), Some(Body::Mover(0)));
        let mut gaps = PerBody::new(bodies, 0.0);
        gaps[Body::Unknown(2)] = 1.0;
        gaps[Body::Mover(1)] = 2.0;
        let values: Vec<f64> = gaps.iter().map(|(_, &gap)| gap).collect();
        assert_eq!(values, [0.0, 0.0, 0.0, 1.0, 0.0, 2.0]);
    }
}
