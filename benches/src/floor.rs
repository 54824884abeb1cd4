//! The floor of a decision: only the loads and the arithmetic that the answer needs, and nothing else.
//!
//! For each candidate: the pose after each step by a rotation recurrence, one bilinear lookup of the squared distance at
//! each pose, the minimum over the rollout; then heading, clearance and speed, normalised and weighed, and the best. There is
//! no map but the table, no window, no contact, no braking rule, no mover, no check of any kind.

use simrun::geometry::{Pose, Twist, Vec2};
use simrun::map::OccupancyGrid;
use simrun::robot::Robot;

/// Candidates side by side.
const LANES: usize = 8;
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
                let v = at(robot.speed_min_mps(), robot.speed_max_mps, i);
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

/// Adding and subtracting it rounds to a whole number.
const ROUND: f32 = 12_582_912.0;
/// Added to a whole number, it leaves that number in the mantissa.
const TO_MANTISSA: f32 = 8_388_608.0;

/// End of a block, and the least squared distance on its way.
fn drive(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    assert_eq!(forms.len(), SIDE * SIDE);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[expect(unsafe_code, reason = "the processor has been asked for AVX2 one line above")]
        return unsafe { drive_avx2(block, heading, fraction, forms) };
    }
    drive_plain(block, heading, fraction, forms)
}

/// All in registers: eight rollouts side by side, eight loads and a transposition for what they look up.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn drive_avx2(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    use std::arch::x86_64::{
        _mm_loadu_ps, _mm256_add_ps, _mm256_and_si256, _mm256_castps_si256, _mm256_castps128_ps256,
        _mm256_insertf128_ps, _mm256_loadu_ps, _mm256_min_epu32, _mm256_min_ps, _mm256_mul_ps, _mm256_set1_epi32,
        _mm256_set1_ps, _mm256_shuffle_ps, _mm256_storeu_ps, _mm256_storeu_si256, _mm256_sub_ps, _mm256_unpackhi_ps,
        _mm256_unpacklo_ps,
    };
    let splat = |number: f32| _mm256_set1_ps(number);
    #[expect(
        unsafe_code,
        reason = "loads and stores of whole lanes, and of cells of the table: each index is cut off at its last"
    )]
    unsafe {
        let step = _mm256_loadu_ps(block.step.as_ptr());
        let turn = [_mm256_loadu_ps(block.turn[0].as_ptr()), _mm256_loadu_ps(block.turn[1].as_ptr())];
        let (mut x, mut y, mut least) = (splat(0.0), splat(0.0), splat(f32::MAX));
        let (mut cos, mut sin) = (splat(heading[0]), splat(heading[1]));
        let shift = fraction.map(|fraction| splat(fraction + (HALF as f32 - 0.5)));
        let mut index = [0u32; LANES];
        for _ in 0..STEPS {
            x = _mm256_add_ps(x, _mm256_mul_ps(step, cos));
            y = _mm256_add_ps(y, _mm256_mul_ps(step, sin));
            let (c, s) = (cos, sin);
            cos = _mm256_sub_ps(_mm256_mul_ps(c, turn[0]), _mm256_mul_ps(s, turn[1]));
            sin = _mm256_add_ps(_mm256_mul_ps(s, turn[0]), _mm256_mul_ps(c, turn[1]));
            let (u, v) = (_mm256_add_ps(x, shift[0]), _mm256_add_ps(y, shift[1]));
            let col = _mm256_sub_ps(_mm256_add_ps(u, splat(ROUND)), splat(ROUND));
            let row = _mm256_sub_ps(_mm256_add_ps(v, splat(ROUND)), splat(ROUND));
            let f = _mm256_add_ps(_mm256_sub_ps(u, col), splat(0.5));
            let g = _mm256_add_ps(_mm256_sub_ps(v, row), splat(0.5));
            let place = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(row, splat(SIDE as f32)), col), splat(TO_MANTISSA));
            let place = _mm256_and_si256(_mm256_castps_si256(place), _mm256_set1_epi32(0x007f_ffff));
            let place = _mm256_min_epu32(place, _mm256_set1_epi32((SIDE * SIDE - 1) as i32));
            _mm256_storeu_si256(index.as_mut_ptr().cast(), place);
            macro_rules! pair {
                ($low:expr, $high:expr) => {{
                    let form = [forms.as_ptr().add(index[$low] as usize), forms.as_ptr().add(index[$high] as usize)];
                    let low = _mm256_castps128_ps256(_mm_loadu_ps(form[0].cast()));
                    _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(form[1].cast()))
                }};
            }
            let (p, q, r, s) = (pair!(0, 4), pair!(1, 5), pair!(2, 6), pair!(3, 7));
            let (pq_low, pq_high) = (_mm256_unpacklo_ps(p, q), _mm256_unpackhi_ps(p, q));
            let (rs_low, rs_high) = (_mm256_unpacklo_ps(r, s), _mm256_unpackhi_ps(r, s));
            let a = _mm256_shuffle_ps::<0b01_00_01_00>(pq_low, rs_low);
            let b = _mm256_shuffle_ps::<0b11_10_11_10>(pq_low, rs_low);
            let c = _mm256_shuffle_ps::<0b01_00_01_00>(pq_high, rs_high);
            let d = _mm256_shuffle_ps::<0b11_10_11_10>(pq_high, rs_high);
            let at_f = [_mm256_add_ps(a, _mm256_mul_ps(b, f)), _mm256_add_ps(c, _mm256_mul_ps(d, f))];
            least = _mm256_min_ps(least, _mm256_add_ps(at_f[0], _mm256_mul_ps(at_f[1], g)));
        }
        let lane = |register| {
            let mut lane = [0.0; LANES];
            _mm256_storeu_ps(lane.as_mut_ptr(), register);
            lane
        };
        (lane(x), lane(y), lane(least))
    }
}

/// The same without AVX2.
fn drive_plain(block: &Block, heading: [f32; 2], fraction: [f32; 2], forms: &[[f32; 4]]) -> (Lane, Lane, Lane) {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    let (mut cos, mut sin) = ([heading[0]; LANES], [heading[1]; LANES]);
    let mut least = [f32::MAX; LANES];
    for _ in 0..STEPS {
        for lane in 0..LANES {
            x[lane] += block.step[lane] * cos[lane];
            y[lane] += block.step[lane] * sin[lane];
            let (c, s) = (cos[lane], sin[lane]);
            cos[lane] = c * block.turn[0][lane] - s * block.turn[1][lane];
            sin[lane] = s * block.turn[0][lane] + c * block.turn[1][lane];
            let (u, v) = (x[lane] + fraction[0] + (HALF as f32 - 0.5), y[lane] + fraction[1] + (HALF as f32 - 0.5));
            let (col, row) = ((u + ROUND) - ROUND, (v + ROUND) - ROUND);
            let (f, g) = (u - col + 0.5, v - row + 0.5);
            let index = (row * SIDE as f32 + col + TO_MANTISSA).to_bits() & 0x007f_ffff;
            let [a, b, c, d] = forms[index as usize];
            least[lane] = least[lane].min(a + b * f + (c + d * f) * g);
        }
    }
    (x, y, least)
}
