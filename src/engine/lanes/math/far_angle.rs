//! Reduction of huge angles, one at a time.
//!
//! Answers: `x = n π/2 + r` with |r| <= π/4, for any finite |x| of at least 1. Method (M. Payne and
//! R. Hanek, *Radian reduction for trigonometric functions*, SIGNUM Newsletter 18 (1983) 19-24): x
//! is `m 2^e` with whole m; of 2/π only those bits count that, times x, are below 4 and above
//! 2^-126. As no double comes nearer to a multiple of π/2 than 2^-62, r has 19 digits.
//!
//! The standard library is not used because its reduction may keep fewer digits: the cosine of
//! 6381956970095103 · 2^797 was found 8 ulp off.

/// 2/π: 64 · 19 bits behind the point.
const TWO_OVER_PI: [u64; 19] = [
    0xa2f9_836e_4e44_1529,
    0xfc27_57d1_f534_ddc0,
    0xdb62_9599_3c43_9041,
    0xfe51_63ab_debb_c561,
    0xb724_6e3a_424d_d2e0,
    0x0649_2eea_09d1_921c,
    0xfe1d_eb1c_b129_a73e,
    0xe882_35f5_2ebb_4484,
    0xe99c_7026_b45f_7e41,
    0x3991_d639_8353_39f4,
    0x9c84_5f8b_bdf9_283b,
    0x1ff8_97ff_de05_980f,
    0xef2f_118b_5a0a_6d1f,
    0x6d36_7ecf_27cb_09b7,
    0x4f46_3f66_9e5f_ea2d,
    0x7527_bac7_ebe5_f17b,
    0x3d07_39f7_8a52_92ea,
    0x6bfb_5fb1_1f8d_5d08,
    0x5603_3046_fc7b_6bab,
];

/// π/2 as a sum.
const HALF_PI: (f64, f64) = (std::f64::consts::FRAC_PI_2, 6.123233995736766e-17);

/// n (its last two bits count) and r as a sum of two numbers, for a finite x of at least 1 in size.
pub(super) fn reduce(x: f64) -> (u64, (f64, f64)) {
    let bits = x.to_bits();
    let m = (bits & ((1 << 52) - 1)) | (1 << 52);
    let e = ((bits >> 52) & 0x7ff) as i64 - 1075;
    // 192 bits of 2/π: times 2^e the first is worth 2.
    let [a, b, c] = [e - 2, e + 62, e + 126].map(two_over_pi_from);
    // Times m, modulo 4: the whole number in the first two bits, the fraction in those behind.
    let middle = u128::from(m) * u128::from(b) + ((u128::from(m) * u128::from(c)) >> 64);
    let high = m.wrapping_mul(a).wrapping_add((middle >> 64) as u64);
    let fraction = ((u128::from(high) << 64) | u128::from(middle as u64)) << 2;
    // Modulo 1 a fraction from a half on is negative: that of the next whole number.
    let n = (high >> 62).wrapping_add((high >> 61) & 1);
    let fraction = fraction as i128;
    let leading = fraction as f64;
    let rest = fraction.wrapping_sub(leading as i128) as f64;
    let scale = 2.0_f64.powi(-128);
    let (leading, rest) = (leading * scale, rest * scale);
    let high = leading * HALF_PI.0;
    let low = leading.mul_add(HALF_PI.0, -high) + (leading * HALF_PI.1 + rest * HALF_PI.0);
    if x < 0.0 { (n.wrapping_neg(), (-high, -low)) } else { (n, (high, low)) }
}

/// 64 bits of 2/π, the first at `2^-(i + 1)`.
fn two_over_pi_from(i: i64) -> u64 {
    let word = |j: i64| usize::try_from(j).ok().and_then(|j| TWO_OVER_PI.get(j)).copied();
    let (j, offset) = (i.div_euclid(64), i.rem_euclid(64));
    let pair = [word(j), word(j + 1)].map(|word| u128::from(word.unwrap_or(0)));
    (((pair[0] << 64 | pair[1]) << offset) >> 64) as u64
}
