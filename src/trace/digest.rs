//! The digest of a trace: equal for equal drives in every build.

use super::{MoverState, PlannedPath, Tick, Trace};
use crate::geometry::{Path, Piece, Pose, Twist, Vec2};
use crate::math;
use crate::plan::contract::Notes;

/// A digest of the drive: every tick, mover and path, to the last bit. The judgement of the episode is not part of it.
///
/// Equal traces have equal digests in every build. That two different ones agree by chance has a
/// probability of about 2⁻⁶⁴; it is no defence against someone who looks for such a pair.
///
/// # Panics
/// If the trace holds a number that is not finite.
pub fn digest(trace: &Trace) -> u64 {
    let mut digest = Digest::default();
    digest.count(trace.ticks.len());
    for tick in &trace.ticks {
        digest.tick(tick);
    }
    digest.count(trace.mover_count);
    for &MoverState { position, velocity, present } in &trace.movers {
        if present {
            digest.point(position);
            digest.point(velocity);
        } else {
            digest.text("absent");
        }
    }
    // `contact_s` is a judgement, and follows from the last row.
    // Without a scanner nothing is added, so that such traces keep their digest.
    for &range_m in &trace.ranges_m {
        if range_m.is_finite() { digest.real(range_m) } else { digest.text("nothing") }
    }
    // Nor if the planner publishes no numbers.
    for &note in trace.notes.iter().flat_map(Notes::values) {
        digest.real(note);
    }
    digest.count(trace.paths.len());
    for PlannedPath { tick, path } in &trace.paths {
        digest.word(u64::from(*tick));
        digest.path(path);
    }
    digest.0
}

/// A running digest: each word is mixed in by the finaliser of SplitMix64 (G. Steele, D. Lea, C. Flood, Fast
/// splittable pseudorandom number generators, OOPSLA 2014), a bijection in which every bit moves every other.
/// Its order matters, and whatever has no fixed size is preceded by its count.
#[derive(Default)]
struct Digest(u64);

impl Digest {
    fn word(&mut self, word: u64) {
        let mut z = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = z ^ (z >> 31);
    }

    fn count(&mut self, count: usize) {
        self.word(count as u64);
    }

    fn real(&mut self, x: f64) {
        self.word(math::canonical(x).to_bits());
    }

    fn text(&mut self, text: &str) {
        self.count(text.len());
        text.bytes().for_each(|byte| self.word(u64::from(byte)));
    }

    fn point(&mut self, p: Vec2) {
        self.real(p.x);
        self.real(p.y);
    }

    fn pose(&mut self, pose: Pose) {
        self.point(pose.position);
        self.real(pose.theta);
    }

    fn twist(&mut self, twist: Twist) {
        self.real(twist.v);
        self.real(twist.omega);
    }

    fn tick(&mut self, tick: &Tick) {
        // Taken apart without `..`, so that a new field cannot be forgotten here.
        let &Tick {
            tick,
            pose,
            believed,
            twist,
            command,
            state,
            sub_goal,
            clearance_m,
            clearance_low_m,
            path_deviation_m,
            sensed_movers,
            seen_statics,
        } = tick;
        self.word(u64::from(tick));
        self.pose(pose);
        self.pose(believed);
        self.twist(twist);
        self.twist(command);
        self.text(state.name);
        self.point(sub_goal);
        self.real(clearance_m);
        self.real(clearance_low_m);
        self.word(u64::from(path_deviation_m.is_some()));
        self.real(path_deviation_m.unwrap_or_default());
        self.word(u64::from(sensed_movers));
        self.word(u64::from(seen_statics));
    }

    /// Adds the pieces, and the times and named key nodes if there are any, so that paths without them keep their digest.
    fn path(&mut self, path: &Path) {
        self.point(path.start());
        self.count(path.pieces().len());
        for piece in path.pieces() {
            match *piece {
                Piece::Line { to } => {
                    self.word(0);
                    self.point(to);
                }
                Piece::Arc { to, centre, sweep } => {
                    self.word(1);
                    self.point(to);
                    self.point(centre);
                    self.real(sweep);
                }
                Piece::Curve(ref curve) => {
                    self.word(2);
                    curve.coefficients().iter().for_each(|&coefficient| self.point(coefficient));
                }
            }
        }
        for &time_s in path.times_s() {
            self.real(time_s);
        }
        if path.has_named_nodes() {
            let mut nodes = Vec::new();
            path.key_nodes(&mut nodes);
            for node in nodes {
                self.point(node.position);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::trace;
    use super::*;
    use crate::plan::contract::State;

    #[test]
    fn every_field_moves_the_digest() {
        let base = digest(&trace());
        type Change = (&'static str, fn(&mut Trace));
        let changes: [Change; 22] = [
            ("row", |t| t.ticks.truncate(1)),
            ("tick", |t| t.ticks[1].tick = 2),
            ("pose", |t| t.ticks[1].pose.position.x = 1.0f64.next_up()),
            ("heading", |t| t.ticks[0].pose.theta = 0.5f64.next_down()),
            ("believed", |t| t.ticks[0].believed.position.y = 2.5),
            ("twist", |t| t.ticks[1].twist.omega = 1e-300),
            ("command", |t| t.ticks[1].command.v = 0.2),
            ("state", |t| t.ticks[1].state = State::TRACK),
            ("sub-goal", |t| t.ticks[0].sub_goal = Vec2::new(2.0, 4.0)),
            ("clearance", |t| t.ticks[0].clearance_m = 0.5),
            ("clearance_low", |t| t.ticks[0].clearance_low_m = 0.5),
            ("deviation", |t| t.ticks[0].path_deviation_m = Some(0.0)),
            ("sensed", |t| t.ticks[0].sensed_movers = 0),
            ("seen", |t| t.ticks[0].seen_statics = 1),
            ("mover", |t| t.movers[3].position.y = 4.0),
            ("velocity", |t| t.movers[2].velocity.y = 1.0),
            ("order of movers", |t| t.movers.swap(0, 1)),
            ("path tick", |t| t.paths[0].tick = 1),
            ("path", |t| t.paths[0].path = Path::polyline(&[Vec2::new(1.0, 2.0), Vec2::new(2.0, 9.0)])),
            ("notes", |t| t.notes = vec![Notes::new(&[0.5])]),
            ("times", |t| t.paths[0].path = t.paths[0].path.clone().with_times(vec![1.0, 2.0])),
            ("key nodes", |t| {
                t.paths[0].path = t.paths[0].path.clone().with_key_nodes(&[Vec2::new(1.0, 2.0), Vec2::new(2.0, 9.0)])
            }),
        ];
        let mut seen = vec![base];
        for (what, change) in changes {
            let mut changed = trace();
            change(&mut changed);
            let digest = digest(&changed);
            assert!(!seen.contains(&digest), "{what} does not show in the digest");
            seen.push(digest);
        }
    }

    #[test]
    fn the_digest_is_fixed_and_blind_to_the_sign_of_zero() {
        // Written down once; a build that disagrees is not comparable with the others.
        assert_eq!(digest(&trace()), DIGEST);
        assert_eq!(digest(&Trace::default()), EMPTY);
        let mut signed = trace();
        signed.ticks[0].twist.v = -0.0;
        signed.expanded = 99; // how hard the planner worked is not what happened
        assert_eq!(digest(&signed), DIGEST);
    }

    const DIGEST: u64 = 0x4bb7_1ccc_4b8f_97aa;
    const EMPTY: u64 = 0x2382_75bc_38fc_be91; // three counts of 0, computed apart
}
