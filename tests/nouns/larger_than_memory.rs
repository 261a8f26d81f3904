//! Campaigns larger than the memory for them: the same numbers as held ones, bit by bit.

use homepoint::campaign::record::{BLOCK, Change, Record};
use homepoint::campaign::recorder::{Recorder, Store};
use homepoint::campaign::{Samples, Track};

/// Samples with every kind of input and gaps at the start, in the middle and at the end.
fn samples(count: usize) -> Samples {
    let number = |i: usize, k: usize| ((i * 7 + k) as f64).sin();
    let gappy = |i: usize, k: usize| {
        if i < 3 || i % 5 == 4 || i + 1 == count { f64::NAN } else { number(i, k) }
    };
    let column = |value: &dyn Fn(usize, usize) -> f64, k: usize| {
        (0..count).map(|i| value(i, k)).collect::<Vec<f64>>()
    };
    let times: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.1).collect();
    let values: Vec<f64> = times.iter().map(|t| t.sin()).collect();
    let smoothing = homepoint::campaign::spline::Smoothing::TimeConstant(0.05);
    let spline = homepoint::campaign::spline::Spline::fit(&times, &values, smoothing).unwrap();
    Samples {
        time: (0..count).map(|i| 1e9 + i as f64 * 1e-3 + 1e-5 * number(i, 9)).collect(),
        inputs: vec![
            Track::Captured {
                value: column(&gappy, 0),
                rate: None,
                acceleration: Some(column(&number, 1)),
            },
            Track::Constant(20.5),
            Track::Logged(spline.into()),
            Track::Absent,
            Track::Captured { value: column(&number, 2), rate: None, acceleration: None },
        ],
        readings: (3..6).map(|k| column(&gappy, k)).collect(),
        rows: (0..count).map(|i| 3 * i + 2).collect(),
        ..Samples::default()
    }
}

/// Kept within a budget, pushed in pieces of uneven length.
fn kept(samples: &Samples, memory: u64, piece: usize) -> Record {
    let mut store = Store::new(memory);
    let mut recorder = Recorder::new(&samples.inputs, samples.readings.len());
    let whole = Record::held(samples.clone());
    let mut scratch = Samples::default();
    for range in whole.ranges(piece) {
        // A stretch's columns are the whole run's; a head's are its own.
        let stretch = whole.stretch(range, &mut scratch);
        let mut part = Samples::default();
        part.clone_from(samples);
        cut(&mut part, stretch.range());
        recorder.push(&mut store, &part).unwrap();
    }
    recorder.finish(&mut store).unwrap()
}

fn cut(samples: &mut Samples, range: std::ops::Range<usize>) {
    let keep = |column: &mut Vec<f64>| *column = column[range.clone()].to_vec();
    keep(&mut samples.time);
    samples.readings.iter_mut().for_each(keep);
    samples.rows = samples.rows[range.clone()].to_vec();
    for track in &mut samples.inputs {
        if let Track::Captured { value, rate, acceleration } = track {
            keep(value);
            rate.iter_mut().chain(acceleration).for_each(keep);
        }
    }
}

/// Every number of some samples of a stretch, bit by bit.
fn bits(samples: &Samples, range: std::ops::Range<usize>) -> Vec<Vec<u64>> {
    let part = |column: &Vec<f64>| column[range.clone()].iter().map(|x| x.to_bits()).collect();
    let clocks =
        [&samples.time, &samples.run_time, &samples.setup_time, &samples.uniform_time].map(part);
    let mut all: Vec<Vec<u64>> =
        clocks.into_iter().chain(samples.readings.iter().map(part)).collect();
    for track in &samples.inputs {
        for order in 0..3 {
            let at = |i: usize| track.at(i, samples.time[i], 0.25_f64, order).to_bits();
            all.push(range.clone().map(at).collect());
        }
    }
    all.push(samples.rows[range].iter().map(|row| *row as u64).collect());
    all
}

#[test]
fn a_spilled_record_lends_what_a_held_one_does() {
    let count = 2 * BLOCK + 100;
    let given = samples(count);
    let held = kept(&given, u64::MAX, count);
    let spilled = kept(&given, 0, 1000);
    let late = kept(&given, 500_000, 777);
    assert!(!held.is_spilled() && spilled.is_spilled() && late.is_spilled());
    assert_eq!((held.len(), spilled.len(), late.len()), (count, count, count));
    let mut scratches = [Samples::default(), Samples::default(), Samples::default()];
    let [one, two, three] = &mut scratches;
    let ranges =
        [0..count, 0..1, 5..5, BLOCK - 2..BLOCK + 2, 100..2 * BLOCK + 7, count - 1..count + 9];
    for range in ranges.into_iter().chain(held.ranges(3000)) {
        let a = held.stretch(range.clone(), one);
        let expected = bits(a.samples, a.range());
        for record in [&spilled, &late] {
            let b = record.stretch(range.clone(), two);
            assert_eq!((b.start, b.first, b.len), (0, a.first, a.len));
            assert_eq!(bits(b.samples, b.range()), expected, "{range:?}");
            for change in [Change::WithoutReadings, Change::Retimed(-0.5)] {
                let (held, spilled) = (held.changed(change), record.changed(change));
                let mut scratch = Samples::default();
                let a = held.stretch(range.clone(), three);
                let b = spilled.stretch(range.clone(), &mut scratch);
                assert_eq!(bits(b.samples, b.range()), bits(a.samples, a.range()));
            }
        }
    }
    assert_eq!(bits(spilled.whole(), 0..count), bits(held.whole(), 0..count));
    assert_eq!(spilled.row(BLOCK + 3), 3 * (BLOCK + 3) + 2);
    assert_eq!((spilled.fault(), spilled.first_time()), (None, held.first_time()));
}

#[test]
fn missing_inputs_take_the_nearest_earlier_else_later_value() {
    for memory in [0, u64::MAX] {
        let record = kept(&samples(100), memory, 7);
        let whole = record.whole();
        let Track::Captured { value, .. } = &whole.inputs[0] else { unreachable!() };
        assert_eq!(value[..4], [21.0_f64.sin(); 4], "before the first one");
        assert_eq!((value[4], value[99]), (value[3], value[98]));
        assert!(whole.readings[0][4].is_nan(), "a reading stays missing");
    }
}

#[test]
fn a_change_is_another_look_and_an_edit_another_record() {
    for memory in [0, u64::MAX] {
        let record = kept(&samples(300), memory, 300);
        let mut blank = record.changed(Change::WithoutReadings);
        assert!(blank.whole().readings.iter().flatten().all(|value| value.is_nan()));
        assert!(record.whole().readings[0][10].is_finite());
        let turned = record.changed(Change::Retimed(-2.0));
        let (spline, captured) = (&record.inputs()[2], &turned.whole().inputs[2]);
        let time = record.whole().time[5];
        assert_eq!(captured.at(5, time, 0.0_f64, 1), -2.0 * spline.at(5, time, 0.0_f64, 1));
        assert_eq!(captured.at(5, time, 0.0_f64, 0), spline.at(5, time, 0.0_f64, 0));
        blank.edit(|samples| samples.readings[1][7] = 42.0);
        assert!(!blank.is_spilled() && blank.whole().readings[1][7] == 42.0);
        assert!(blank.whole().readings[1][8].is_nan());
    }
}

#[test]
fn readings_left_out_are_missing_wherever_they_are_looked_at() {
    let count = BLOCK + 300;
    let out = [
        (7..8, 1..2),
        (BLOCK - 3..BLOCK + 5, 0..2),
        (BLOCK + 2..BLOCK + 9, 1..2),
        (count - 3..count - 1, 0..1),
    ];
    for memory in [0, u64::MAX] {
        let record = kept(&samples(count), memory, count);
        let mut less = record.clone();
        less.leave_out(out.iter().cloned());
        let mut edited = record.clone();
        edited.edit(|samples| {
            for (samples_out, columns) in &out {
                for column in &mut samples.readings[columns.clone()] {
                    column[samples_out.clone()].fill(f64::NAN);
                }
            }
        });
        assert_eq!(less.is_spilled(), memory == 0);
        assert_eq!(bits(less.whole(), 0..count), bits(edited.whole(), 0..count));
        assert!(record.whole().readings[1][7].is_finite(), "it is another look");
        let (mut one, mut two) = (Samples::default(), Samples::default());
        for range in [0..7, 7..8, 5..BLOCK, BLOCK + 4..BLOCK + 6, 0..count, count - 1..count] {
            let a = less.stretch(range.clone(), &mut one);
            let b = edited.stretch(range.clone(), &mut two);
            assert_eq!(bits(a.samples, a.range()), bits(b.samples, b.range()), "{range:?}");
        }
        assert_eq!(bits(&less.head(9), 0..9), bits(&edited.head(9), 0..9));
        less.leave_out([(20..30, 0..1)]);
        assert!(less.whole().readings[0][25].is_nan(), "what was looked at before is forgotten");
        less.edit(|samples| samples.readings[1][7] = 42.0);
        assert_eq!(less.whole().readings[1][7], 42.0);
        assert!(less.whole().readings[0][25].is_nan());
        let slower = edited.changed(Change::Retimed(0.5));
        let mut both = record.changed(Change::Retimed(0.5));
        both.leave_out(out.iter().cloned());
        assert_eq!(bits(both.whole(), 0..count), bits(slower.whole(), 0..count));
    }
}

#[test]
fn records_share_a_store_until_its_memory_is_used_up() {
    let given = samples(100);
    let mut store = Store::new(30_000);
    let records: Vec<Record> = (0..4)
        .map(|_| {
            let mut recorder = Recorder::new(&given.inputs, given.readings.len());
            recorder.push(&mut store, &given).unwrap();
            recorder.finish(&mut store).unwrap()
        })
        .collect();
    let spilled: Vec<bool> = records.iter().map(Record::is_spilled).collect();
    assert_eq!(spilled, [false, false, false, true], "11 numbers a sample");
    for record in &records {
        assert_eq!(bits(record.whole(), 0..100), bits(records[0].whole(), 0..100));
    }
}

#[test]
fn a_share_of_a_run_is_spread_over_all_of_it() {
    let record = kept(&samples(10_000), u64::MAX, 10_000);
    let ranges = |share: f64| record.share(share, 128).collect::<Vec<_>>();
    assert_eq!(ranges(1.0), record.ranges(128).collect::<Vec<_>>());
    assert_eq!(ranges(7.5), ranges(1.0), "more than all is all");
    let tenth = ranges(0.1);
    assert_eq!(tenth.len(), 8, "of 79 pieces");
    let gaps = tenth.windows(2).map(|pair| (pair[1].start - pair[0].start) / 128);
    assert!(gaps.into_iter().all(|pieces| (9..=11).contains(&pieces)), "{tenth:?}");
    assert_eq!(ranges(1e-9).len(), 1, "a short look is better than none");
}
