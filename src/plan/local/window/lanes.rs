//! Eight numbers side by side, for the kernels of the window.
//!
//! [`Lanes`] is what a kernel may do with them: plain arithmetic of IEEE 754, one operation at a time, never fused. So
//! every kind of lanes gives the same bits, and which one runs is a matter of speed alone: [`Wide`] where the processor
//! has AVX2, else [`Plain`], which the compiler turns into whatever vectors the target has. [`Width`] says which.

use core::ops::{Add, Mul, Sub};

/// Numbers side by side.
pub(super) const LANES: usize = 8;

/// One number per lane, in memory.
pub(super) type Lane = [f32; LANES];

/// Which lanes a kernel runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Width {
    /// Only ever true where the processor has AVX2.
    is_wide: bool,
}

impl Width {
    /// The lanes that run on any processor.
    #[cfg(any(test, not(target_arch = "x86_64")))]
    pub(crate) const PLAIN: Self = Self { is_wide: false };

    /// The fastest lanes that this processor has.
    pub(crate) fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        return Self { is_wide: std::arch::is_x86_feature_detected!("avx2") };
        #[cfg(not(target_arch = "x86_64"))]
        Self::PLAIN
    }

    /// Whether the processor has AVX2, and it is to be used.
    pub(crate) fn is_wide(self) -> bool {
        self.is_wide
    }
}

/// Defines a function that runs its kernel on the lanes of the [`Width`] that comes first.
///
/// `kernel` is a function generic over [`Lanes`] and `#[inline(always)]`, so that it is compiled once for each.
macro_rules! on_lanes {
    ($(#[$about:meta])* pub(super) fn $name:ident($($arg:ident: $type:ty),* $(,)?) -> $out:ty = $kernel:ident;) => {
        $(#[$about])*
        pub(super) fn $name(width: $crate::plan::local::window::lanes::Width, $($arg: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            if width.is_wide() {
                #[target_feature(enable = "avx2")]
                fn wide($($arg: $type),*) -> $out {
                    $kernel::<$crate::plan::local::window::lanes::Wide>($($arg),*)
                }
                #[expect(unsafe_code, reason = "a width is wide only where the processor has been asked for AVX2")]
                return unsafe { wide($($arg),*) };
            }
            $kernel::<$crate::plan::local::window::lanes::Plain>($($arg),*)
        }
    };
}
pub(super) use on_lanes;

/// Arithmetic on [`LANES`] numbers at once.
pub(super) trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The same number in every lane.
    fn splat(number: f32) -> Self;
    /// Loads the lanes from memory.
    fn load(lane: &Lane) -> Self;
    /// Stores the lanes to memory.
    fn store(self) -> Lane;
    /// The smaller one of each lane; `other`'s where they are equal.
    fn min(self, other: Self) -> Self;
    /// `share` in the lanes where `self` is larger than `limit`, else 0.
    fn where_above(self, limit: Self, share: Self) -> Self;
    /// Whether any lane is not 0.
    fn any(self) -> bool;
    /// Entry ⌊index⌋ of a table for each lane, transposed: the first numbers of all entries, then the second ones and so on. The
    /// index comes as 2²³ + index, so that it stands in the mantissa; an index past the table gives an arbitrary entry or panics.
    fn look_up(self, table: &[[f32; 4]]) -> [Self; 4];
}

/// The bits of a mantissa.
const MANTISSA: u32 = 0x007f_ffff;

/// Lanes on any processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain(Lane);

macro_rules! plain {
    ($trait:ident $method:ident $operator:tt) => {
        impl $trait for Plain {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for lane in 0..LANES {
                    self.0[lane] $operator other.0[lane];
                }
                self
            }
        }
    };
}
plain!(Add add +=);
plain!(Sub sub -=);
plain!(Mul mul *=);

impl Lanes for Plain {
    #[inline(always)]
    fn splat(number: f32) -> Self {
        Self([number; LANES])
    }

    #[inline(always)]
    fn load(lane: &Lane) -> Self {
        Self(*lane)
    }

    #[inline(always)]
    fn store(self) -> Lane {
        self.0
    }

    #[inline(always)]
    fn min(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] = if self.0[lane] < other.0[lane] { self.0[lane] } else { other.0[lane] };
        }
        self
    }

    #[inline(always)]
    fn where_above(mut self, limit: Self, share: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] = if self.0[lane] > limit.0[lane] { share.0[lane] } else { 0.0 };
        }
        self
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().fold(0, |bits, number| bits | number.to_bits()) != 0
    }

    #[inline(always)]
    fn look_up(self, table: &[[f32; 4]]) -> [Self; 4] {
        let mut index = [0; LANES];
        for (index, number) in index.iter_mut().zip(self.0) {
            *index = number.to_bits() & MANTISSA;
        }
        let [mut a, mut b, mut c, mut d] = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            [a[lane], b[lane], c[lane], d[lane]] = table[index[lane] as usize];
        }
        [Self(a), Self(b), Self(c), Self(d)]
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use wide::Wide;

/// The compiler's own vectors of [`Plain`] take entries of the table apart number by number, which doubles the time of a
/// rollout; so this one is written out.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "measured: half the time of a rollout; all of it runs only inside `on_lanes`, under AVX2"
)]
mod wide {
    use super::{LANES, Lane, Lanes, MANTISSA};
    use core::arch::x86_64::{
        __m256, _CMP_GT_OQ, _mm_loadu_ps, _mm256_add_ps, _mm256_and_ps, _mm256_and_si256, _mm256_castps_si256,
        _mm256_castps128_ps256, _mm256_cmp_ps, _mm256_insertf128_ps, _mm256_loadu_ps, _mm256_min_epu32, _mm256_min_ps,
        _mm256_mul_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_shuffle_ps, _mm256_storeu_ps, _mm256_storeu_si256,
        _mm256_sub_ps, _mm256_testz_si256, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
    };
    use core::ops::{Add, Mul, Sub};

    /// Lanes of AVX2.
    #[derive(Clone, Copy, Debug)]
    pub(in super::super) struct Wide(__m256);

    macro_rules! wide {
        ($trait:ident $method:ident $instruction:ident) => {
            impl $trait for Wide {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(unsafe { $instruction(self.0, other.0) })
                }
            }
        };
    }
    wide!(Add add _mm256_add_ps);
    wide!(Sub sub _mm256_sub_ps);
    wide!(Mul mul _mm256_mul_ps);

    impl Lanes for Wide {
        #[inline(always)]
        fn splat(number: f32) -> Self {
            Self(unsafe { _mm256_set1_ps(number) })
        }

        #[inline(always)]
        fn load(lane: &Lane) -> Self {
            Self(unsafe { _mm256_loadu_ps(lane.as_ptr()) })
        }

        #[inline(always)]
        fn store(self) -> Lane {
            let mut lane = [0.0; LANES];
            unsafe { _mm256_storeu_ps(lane.as_mut_ptr(), self.0) };
            lane
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn where_above(self, limit: Self, share: Self) -> Self {
            Self(unsafe { _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, limit.0), share.0) })
        }

        #[inline(always)]
        fn any(self) -> bool {
            let bits = unsafe { _mm256_castps_si256(self.0) };
            unsafe { _mm256_testz_si256(bits, bits) == 0 }
        }

        #[inline(always)]
        fn look_up(self, table: &[[f32; 4]]) -> [Self; 4] {
            assert!(!table.is_empty(), "a table has entries");
            let last = (table.len() - 1).min(i32::MAX as usize) as i32;
            let mut index = [0u32; LANES];
            unsafe {
                let bits = _mm256_and_si256(_mm256_castps_si256(self.0), _mm256_set1_epi32(MANTISSA as i32));
                let within = _mm256_min_epu32(bits, _mm256_set1_epi32(last));
                _mm256_storeu_si256(index.as_mut_ptr().cast(), within);
            }
            unsafe {
                // Entries of lanes k and k + 4 in the halves of one vector; then a transposition of 4 × 4 in each half.
                // (No closure: one would not have AVX2, and every instruction would become a call.)
                let p = pair(table, index[0], index[4]);
                let q = pair(table, index[1], index[5]);
                let r = pair(table, index[2], index[6]);
                let s = pair(table, index[3], index[7]);
                let (pq_low, pq_high) = (_mm256_unpacklo_ps(p, q), _mm256_unpackhi_ps(p, q));
                let (rs_low, rs_high) = (_mm256_unpacklo_ps(r, s), _mm256_unpackhi_ps(r, s));
                [
                    Self(_mm256_shuffle_ps::<0b01_00_01_00>(pq_low, rs_low)),
                    Self(_mm256_shuffle_ps::<0b11_10_11_10>(pq_low, rs_low)),
                    Self(_mm256_shuffle_ps::<0b01_00_01_00>(pq_high, rs_high)),
                    Self(_mm256_shuffle_ps::<0b11_10_11_10>(pq_high, rs_high)),
                ]
            }
        }
    }

    /// Two entries of a table in one vector; both indices must lie within the table.
    #[inline(always)]
    unsafe fn pair(table: &[[f32; 4]], low: u32, high: u32) -> __m256 {
        unsafe {
            let low = _mm_loadu_ps(table.get_unchecked(low as usize).as_ptr());
            let high = _mm_loadu_ps(table.get_unchecked(high as usize).as_ptr());
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
        }
    }
}
