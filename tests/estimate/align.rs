//! Horn's alignment.

use homepoint::estimate::align::{Degenerate, Pair, align};
use homepoint::quaternion::Quaternion;
use proptest::prelude::*;

use crate::problems::Stream;
use crate::problems::wahba::turned;

fn pairs(turn: [f64; 3], shift: [f64; 3], scale: f64, count: usize, mirror: f64) -> Vec<Pair> {
    let mut stream = Stream(7);
    let q = Quaternion::turn(turn);
    (0..count)
        .map(|_| {
            let source = [stream.next(), 2.0 * stream.next(), 3.0 * stream.next()];
            let p = turned(q, source);
            let target =
                [0, 1, 2].map(|i| scale * p[i] * if i == 0 { mirror } else { 1.0 } + shift[i]);
            Pair { source, target, weight: 1.5 + stream.next() }
        })
        .collect()
}

proptest! {
    #[test]
    fn any_transformation_is_recovered(
        turn in prop::array::uniform3(-3.0..3.0f64),
        shift in prop::array::uniform3(-10.0..10.0f64),
        scale in 0.1..10.0f64,
        count in 3usize..20,
    ) {
        let found = align(&pairs(turn, shift, scale, count, 1.0), true).unwrap();
        prop_assert!((found.scale / scale - 1.0).abs() < 1e-12);
        prop_assert!(found.rms < 1e-12 * (scale + 10.0));
        for v in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let (a, b) = (turned(found.rotation, v), turned(Quaternion::turn(turn), v));
            prop_assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-11), "{a:?} {b:?}");
        }
        prop_assert!((0..3).all(|i| (found.translation[i] - shift[i]).abs() < 1e-10));
        prop_assert!(found.rotation.w >= 0.0);
    }
}

#[test]
fn a_mirror_image_is_not_answered_by_a_reflection() {
    let found = align(&pairs([0.3, 0.2, -0.5], [0.0; 3], 1.0, 12, -1.0), false).unwrap();
    let q = found.rotation;
    let norm = q.w * q.w + q.v.iter().map(|x| x * x).sum::<f64>();
    assert!((norm - 1.0).abs() < 1e-14, "a rotation");
    assert!(found.rms > 0.3, "and an honest misfit: {}", found.rms);
}

#[test]
fn weights_count() {
    let mut points = pairs([0.1, 0.0, 0.4], [1.0, 2.0, 3.0], 1.0, 10, 1.0);
    points[4].target[1] += 0.5;
    let all = align(&points, false).unwrap();
    points[4].weight = 0.0;
    let without = align(&points, false).unwrap();
    assert!(all.rms > 0.05 && without.rms < 1e-14);
    assert!((all.scale, without.scale) == (1.0, 1.0));
}

#[test]
fn degenerate_points_are_refused_in_words() {
    let good = pairs([0.1, 0.0, 0.4], [1.0, 2.0, 3.0], 1.0, 10, 1.0);
    assert_eq!(align(&good[..2], false), Err(Degenerate::TooFew(2)));
    let line: Vec<_> = (0..5)
        .map(|i| {
            let x = 0.3 + f64::from(i);
            Pair { source: [x, 2.0 * x, 1.0 - x], target: [x, x, x], weight: 1.0 }
        })
        .collect();
    assert_eq!(align(&line, true), Err(Degenerate::Collinear));
    let place: Vec<_> = good.iter().map(|p| Pair { source: [1.0; 3], ..*p }).collect();
    assert!(matches!(align(&place, true), Err(Degenerate::Coincident | Degenerate::Collinear)));
    // A cube's corners and their negatives: every half turn fits as well as any other.
    let cube: Vec<_> = (0..8)
        .map(|i| {
            let s = [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
            Pair { source: s, target: s.map(|x: f64| -x), weight: 1.0 }
        })
        .collect();
    assert_eq!(align(&cube, true), Err(Degenerate::Ambiguous));
    let mut broken = good;
    broken[3].target[0] = f64::NAN;
    assert_eq!(align(&broken, true), Err(Degenerate::NotFinite(3)));
    assert!(Degenerate::Collinear.to_string().contains("add points off it"));
}
