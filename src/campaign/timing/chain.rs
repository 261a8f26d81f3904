//! How well a reference time is known: the timing chain, link by link (type B, GUM 4.3).
//!
//! | link | standard uncertainty | part |
//! |---|---|---|
//! | `edge` | rise / √12: the controller switches somewhere in it, the middle is taken | common |
//! | `controller_gate` | at most g: g / √12 about g / 2; else as stated | common |
//! | `baud_rate` | length of the request · tolerance / √3 | common |
//! | `resolution` | step / √12 | random |
//! | `jitter` | as stated | random |
//!
//! The common part is one and the same error of all reference times, the random part is new in
//! every sample and shared by its readings.
//!
//! The lag of eq. (1), `Δt = t4 - t3`, is by how much later the calibration system's gate lets the
//! trigger through than the instrument's does. A delay counted from the instrument's own trigger
//! point is shorter by the instrument's gate delay.

use crate::campaign::statement::Spread;
use crate::campaign::timing::{Gate, Line, Method, Reference, RunTiming, Timing};

/// One link of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: &'static str,
    /// Standard uncertainty (s).
    pub spread: Spread,
    /// One error for all samples, else new in every sample.
    pub is_common: bool,
}

impl Timing {
    /// The links of the chain that are known to be there. Where requests of runs differ in length
    /// the longest counts.
    pub fn chain<'a>(&self, runs: impl IntoIterator<Item = &'a RunTiming>) -> Vec<Link> {
        let longest = runs.into_iter().map(|run| self.length(run)).fold(0.0, f64::max);
        let rectangular =
            |width: f64| Spread { sigma: width / 12.0_f64.sqrt(), ..Spread::default() };
        let baud = match self.method {
            Method::Serial(Line { baud_tolerance, reference: Reference::Complete, .. }) => {
                Some(rectangular(2.0 * longest * baud_tolerance))
            }
            _ => None,
        };
        let jitter = self.jitter.map(|sigma| Spread { sigma, ..Spread::default() });
        [
            ("edge", self.edge.map(rectangular), true),
            ("controller_gate", self.controller_gate.map(|gate| gate.spread), true),
            ("baud_rate", baud, true),
            ("resolution", self.resolution.map(rectangular), false),
            ("jitter", jitter, false),
        ]
        .into_iter()
        .filter_map(|(name, spread, is_common)| Some(Link { name, spread: spread?, is_common }))
        .filter(|link| link.spread.sigma > 0.0)
        .collect()
    }

    /// The lag `Δt = t4 - t3` of eq. (1), if the gate delays of both systems are stated.
    ///
    /// Each system detects somewhere in the edge, so its rise enters twice.
    pub fn lag(&self) -> Option<Gate> {
        let (controller, instrument) = (self.controller_gate?, self.instrument_gate?);
        let edge = self.edge.unwrap_or(0.0) / 6.0_f64.sqrt();
        let gates = controller.spread.sigma.hypot(instrument.spread.sigma);
        let spread = Spread { sigma: gates.hypot(edge), ..Spread::default() };
        Some(Gate { value: controller.value - instrument.value, spread })
    }
}

/// The standard uncertainty (s) of the common part of a chain, or of its random part.
pub fn part(chain: &[Link], common: bool) -> f64 {
    let links = chain.iter().filter(|link| link.is_common == common);
    links.map(|link| link.spread.sigma).fold(0.0, f64::hypot)
}
