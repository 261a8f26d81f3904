//! How large an effect may be: what is beyond that is another unit or a mirrored frame.

use std::path::Path;

use homepoint::diagnose::Diagnosis;
use homepoint::engine::open::{Request, open};

use crate::drawn::run;
use crate::found::{names, told};

/// A part of the recording of the example, its positions times a factor.
fn scaled(factor: f64) -> Diagnosis {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand_eye");
    let opened = open(&Request::new([example])).unwrap();
    let mut problem = opened.problem.clone();
    let slots = problem.parts[0].slots().to_vec();
    let record = &mut problem.parts[0].runs[0].record;
    *record = record.spread(600, 30).into();
    record.edit(|samples| {
        for slot in slots.iter().filter(|slot| slot.width == 1) {
            samples.readings[slot.column].iter_mut().for_each(|value| *value *= factor);
        }
    });
    run(problem, &opened)
}

#[test]
fn a_scale_is_named_and_a_mirrored_frame_is_none() {
    let found = scaled(1.25);
    assert!(names(&found).contains(&"kinematic_scale"), "{}", told(&found));
    let found = scaled(-1.0);
    assert!(!names(&found).contains(&"kinematic_scale"), "{}", told(&found));
    assert!(found.verdict.has_remainder() || !found.verdict.is_made(), "{}", told(&found));
}
