//! The floor of a decision: only the loads and the arithmetic that the answer needs, and nothing else.
//!
//! For each candidate: the pose after each step by a rotation recurrence, one bilinear lookup of the squared distance at
//! each pose, the minimum over the rollout; then heading, clearance and speed, normalised and weighed, and the best. There is
//! no map but the table, no window, no contact, no braking rule, no mover, no check of any kind.

use simrun::geometry::{Pose, Twist, Vec2};
use simrun::map::OccupancyGrid;
use simrun::robot::Robot;

/// Candidates side by side.
const LANES: usize = 16;
const STEPS: usize = 30;
type Lane = [f32; LANES];

/// Cells of the table each way from the robot: 3 m and a little, as many metres as a patch has.
const HALF: usize = 42;
const SIDE: usize = 2 * HALF;

/// Candidates laid out for the floor, and the table that they read.
pub struct Floor {
    pose: Pose,
    goal: Vec2,
    pitch_m: f64,
    radius_m: f64,
    twists: Vec<Twist>,
    /// Per cell a + b f + c g + d f g of the squared distance.
    forms: Vec<[f32; 4]>,
    /// The robot's place inside its cell.
    fraction: [f32; 2],
    blocks: Vec<Block>,
    terms: [Vec<f64>; 3],
}

struct Block {
    step: Lane,
    turn: [Lane; 2],
}

impl Floor {
    /// `samples` speeds and yaw rates over the whole range of the robot.
    pub fn new(map: &OccupancyGrid, pose: Pose, goal: Vec2, robot: &Robot, samples: u32) -> Self {
        let pitch_m = map.resolution_m();
        let at = |low: f64, high: f64, k: u32| low + (high - low) * f64::from(k) / f64::from(samples - 1);
        let mut twists = Vec::new();
        for i in 0..samples {
            for k in 0..samples {
                let v = at(robot.speed_min_mps, robot.speed_max_mps, i);
                twists.push(Twist { v, omega: at(-robot.yaw_rate_max_radps, robot.yaw_rate_max_radps, k) });
            }
        }
        let blocks = twists.chunks(LANES).map(|twists| {
            let lane = |value: &dyn Fn(Twist) -> f64| {
                let mut lane = [0.0; LANES];
                lane.iter_mut().zip(twists).for_each(|(lane, &twist)| *lane = value(twist) as f32);
                lane
            };
            Block {
                step: lane(&|twist| twist.v * 0.1 / pitch_m),
                turn: [lane(&|twist| (twist.omega * 0.1).cos()), lane(&|twist| (twist.omega * 0.1).sin())],
            }
        });
        let lattice = pose.position / pitch_m;
        let first = [lattice.x.floor() - HALF as f64, lattice.y.floor() - HALF as f64];
        let squares: Vec<_> = (0..map.occupied().len()).filter(|&i| map.occupied()[i]).collect();
        let squared = |col: usize, row: usize| {
            let node = Vec2::new(first[0] + col as f64, first[1] + row as f64) * pitch_m;
            let away = |&i: &usize| map.square(map.cell(i)).signed_distance(node).max(0.0) / pitch_m;
            let nearest_m = squares.iter().map(away).fold(f64::INFINITY, f64::min);
            (nearest_m * nearest_m).min(80.0) as f32
        };
        let nodes: Vec<f32> = (0..(SIDE + 1) * (SIDE + 1)).map(|i| squared(i % (SIDE + 1), i / (SIDE + 1))).collect();
        let form = |i: usize| {
            let at = i / SIDE * (SIDE + 1) + i % SIDE;
            let (p, q, r, s) = (nodes[at], nodes[at + 1], nodes[at + SIDE + 1], nodes[at + SIDE + 2]);
            [p, q - p, r - p, (s - r) - (q - p)]
        };
        Self {
            pose,
            goal,
            pitch_m,
            radius_m: robot.radius_m,
            forms: (0..SIDE * SIDE).map(form).collect(),
            fraction: [(lattice.x - lattice.x.floor()) as f32, (lattice.y - lattice.y.floor()) as f32],
            blocks: blocks.collect(),
            terms: std::array::from_fn(|_| vec![0.0; twists.len()]),
            twists,
        }
    }

    /// Points that are looked up.
    pub fn points(&self) -> usize {
        self.twists.len() * STEPS
    }

    /// The best twist.
    pub fn decide(&mut self) -> Twist {
        let heading = [self.pose.theta.cos() as f32, self.pose.theta.sin() as f32];
        for (number, block) in self.blocks.iter().enumerate() {
            let (x, y, least) = drive(block, heading, self.fraction, &self.forms);
            for (lane, i) in (number * LANES..self.twists.len()).take(LANES).enumerate() {
                let end = self.pose.position + Vec2::new(f64::from(x[lane]), f64::from(y[lane])) * self.pitch_m;
                let end = Pose::new(end.x, end.y, self.pose.theta + self.twists[i].omega * 3.0);
                self.terms[0][i] = std::f64::consts::PI - end.bearing_to(self.goal).abs();
                self.terms[1][i] = (f64::from(least[lane].sqrt()) * self.pitch_m - self.radius_m).clamp(0.0, 0.5);
                self.terms[2][i] = self.twists[i].v;
            }
        }
        let sums: [f64; 3] = std::array::from_fn(|k| self.terms[k].iter().sum());
        let [a, b, c] = [0.1 / sums[0], 0.2 / sums[1], 0.1 / sums[2]];
        let (mut best, mut highest) = (0, f64::MIN);
        for i in 0..self.twists.len() {
            let score = a * self.terms[0][i] + b * self.terms[1][i] + c * self.terms[2][i];
            if score > highest {
                (best, highest) = (i, score);
            }
        }
        self.twists[best]
    }
}

/// Where a block ends, and the least squared distance on its way.
fn drive(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[expect(unsafe_code, reason = "the processor has been asked for AVX2 one line above")]
        return unsafe { drive_avx2(block, heading, fraction, forms) };
    }
    drive_lanes(block, heading, fraction, forms)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn drive_avx2(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    drive_lanes(block, heading, fraction, forms)
}

#[inline(always)]
fn drive_lanes(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    const ROUND: f32 = 12_582_912.0;
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    let (mut cos, mut sin) = ([heading[0]; LANES], [heading[1]; LANES]);
    let mut least = [f32::MAX; LANES];
    for _ in 0..STEPS {
        let (mut f, mut g, mut index) = ([0.0; LANES], [0.0; LANES], [0u32; LANES]);
        for lane in 0..LANES {
            x[lane] += block.step[lane] * cos[lane];
            y[lane] += block.step[lane] * sin[lane];
            let (c, s) = (cos[lane], sin[lane]);
            cos[lane] = c * block.turn[0][lane] - s * block.turn[1][lane];
            sin[lane] = s * block.turn[0][lane] + c * block.turn[1][lane];
            let (u, v) = (x[lane] + fraction[0] + (HALF as f32 - 0.5), y[lane] + fraction[1] + (HALF as f32 - 0.5));
            let (col, row) = ((u + ROUND) - ROUND, (v + ROUND) - ROUND);
            (f[lane], g[lane]) = (u - col + 0.5, v - row + 0.5);
            index[lane] = (row * SIDE as f32 + col + 8_388_608.0).to_bits() & 0x007f_ffff;
        }
        let (mut a, mut b, mut c, mut d) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            [a[lane], b[lane], c[lane], d[lane]] = forms[index[lane] as usize];
        }
        for lane in 0..LANES {
            let squared = a[lane] + b[lane] * f[lane] + (c[lane] + d[lane] * f[lane]) * g[lane];
            least[lane] = if squared < least[lane] { squared } else { least[lane] };
        }
    }
    (x, y, least)
}
