//! Residuals with a memory: by how much a plain fit states too small an uncertainty of a mean, against
//! what repeated simulation and the closed form say.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::autocorrelation::autocorrelated;
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

use crate::problems::Stream;
use crate::scale::Scales;

const COUNT: usize = 4096;

/// First-order noise of unit variance: each value keeps a share of the last one.
fn values(share: f64, seed: u64) -> Vec<f64> {
    let mut noise = Stream(seed);
    let mut last = noise.normal();
    let next = |_| {
        last = share * last + (1.0 - share * share).sqrt() * noise.normal();
        5.0 + last
    };
    (0..COUNT).map(next).collect()
}

#[test]
fn noise_with_a_memory_widens_a_mean_as_its_closed_form_says() {
    let scales = Scales::new();
    for (share, name) in [(0.0, "white"), (0.9, "memory")] {
        let folder = scales.campaign(name, "", &values(share, 4));
        let problem = open(&Request::new([folder])).unwrap().problem;
        let fit = calibrate(problem, &Options::default()).unwrap();
        let found = autocorrelated(&fit);
        if share == 0.0 {
            assert!(found.is_empty(), "{found:?}");
            continue;
        }
        let [one] = &found[..] else { panic!("{found:?}") };
        // The variance of a mean of many is (1 + a) / (1 - a) times that of independent values.
        let due = f64::sqrt((1.0 + share) / (1.0 - share));
        assert!((one.times / due - 1.0).abs() < 0.3, "{} for {due}", one.times);
        assert_eq!(one.measurand, "x");
        // And repeated simulation says the same of the mean.
        let means: Vec<f64> = (0..60)
            .map(|seed| values(share, 100 + seed).iter().sum::<f64>() / COUNT as f64 - 5.0)
            .collect();
        let rms = (means.iter().map(|one| one * one).sum::<f64>() / 60.0).sqrt();
        let stated = 1.0 / (COUNT as f64).sqrt();
        assert!((rms / stated / one.times - 1.0).abs() < 0.4, "{} and {}", rms / stated, one.times);
    }
}
