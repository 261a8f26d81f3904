//! Time referencing: when a reading was asked for (Depenthal 2009, sections 2.2 and 2.3).
//!
//! A delay is counted from the measurement request. A campaign with a `[timing]` table carries what
//! the controller captured, and the reference time of each sample follows:
//!
//! | method | captured | reference time |
//! |---|---|---|
//! | `trigger` | the latch `t4` set off by the rising edge | `t4 - g`, g the controller's gate delay |
//! | `serial` | the start bit of the request | start bit `+ n / baud - g`: n bits make the request complete |
//!
//! The inputs captured with it are moved along their rates to the reference time. What is not known
//! of it (where in the edge the controller switches, its gate delay, the resolution of the clock)
//! is a type-B uncertainty, see [`chain`]; it enters the estimate as an effect, see [`enter`].
//!
//! | file | answers |
//! |---|---|
//! | `read` | what `[timing]` and a run's `timing` say |
//! | [`captures`] | the captures of a run made into reference times |
//! | [`replies`] | when replies came, and how far the arm had turned |
//! | `capturing` | a simulated run written as it would have been captured |
//! | [`chain`] | how well a reference time is known, and the lag of eq. (1) |
//! | [`enter`] | the same as an effect of the model |
//!
//! Not here: the instrument's own gate delay, which is part of its delay.

use serde_json::Value;

use crate::campaign::header::TIME;
use crate::campaign::statement::Spread;
use crate::diagnostic::Place;
use crate::document::entries::Named;

pub mod captures;
pub(crate) mod capturing;
pub mod chain;
pub mod enter;
pub(crate) mod read;
pub mod replies;

/// What `[timing]` says.
#[derive(Clone, Debug)]
pub struct Timing {
    /// How the controller learns of a request.
    pub method: Method,
    /// Rise time of the edge (s): it is passed somewhere in it.
    pub edge: Option<f64>,
    /// Resolution of the captured times (s).
    pub resolution: Option<f64>,
    /// Standard deviation of whatever else scatters from capture to capture (s).
    pub jitter: Option<f64>,
    /// Gate delay of the calibration system.
    pub controller_gate: Option<Gate>,
    /// Gate delay of the instrument under test; for the lag of eq. (1) alone.
    pub instrument_gate: Option<Gate>,
    /// When simulated replies come.
    pub reply: Option<Reply>,
    /// As written, to be written again.
    pub written: Value,
    /// Where the table stands.
    pub place: Place,
}

/// How the controller learns of a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// By the rising edge of an external trigger.
    Trigger,
    /// By the start bit of a data item on a serial line.
    Serial(Line),
}

/// A serial line and the request on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Bits in a second (1/s).
    pub baud: f64,
    /// Bound on its relative deviation.
    pub baud_tolerance: f64,
    /// Bits of the request, start, parity and stop bits counted.
    pub bits: f64,
    /// From when on the delay counts.
    pub reference: Reference,
}

/// The moment of a serial request that is its reference point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// All its bits have come in: before that nothing can be measured.
    Complete,
    /// Its start bit begins.
    StartBit,
}

/// A gate delay: its value (s) and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// Best value (s).
    pub value: f64,
    /// Its standard uncertainty.
    pub spread: Spread,
}

/// How long after its request a reply begins, start bit to start bit; for simulation alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reply {
    /// On average (s).
    pub after: f64,
    /// Standard deviation (s).
    pub scatter: f64,
}

/// What a run says of its captures.
#[derive(Clone, Debug, Default)]
pub struct RunTiming {
    /// A file of captures beside the data file, row by row.
    pub captures: Option<Named>,
    /// Bits of the request in this run.
    pub bits: Option<f64>,
}

impl Method {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trigger => "trigger",
            Self::Serial(_) => "serial",
        }
    }

    /// The column in which the captured edge of a request stands.
    pub fn column(self) -> &'static str {
        match self {
            Self::Trigger => TRIGGER,
            Self::Serial(_) => REQUEST,
        }
    }
}

/// Column of the latch set off by a trigger.
const TRIGGER: &str = "trigger";
/// Column of the start bit of a request.
const REQUEST: &str = "request";
/// Column of the start bit of the reply.
const REPLY: &str = "reply";

/// All columns of times, ready or captured.
pub(crate) const COLUMNS: [&str; 4] = [TIME, TRIGGER, REQUEST, REPLY];

impl Timing {
    /// How long a request is (s): zero for a trigger.
    pub fn length(&self, run: &RunTiming) -> f64 {
        match self.method {
            Method::Trigger => 0.0,
            Method::Serial(line) => run.bits.unwrap_or(line.bits) / line.baud,
        }
    }

    /// From a captured edge to the reference time (s).
    pub fn shift(&self, run: &RunTiming) -> f64 {
        let after = match self.method {
            Method::Serial(Line { reference: Reference::Complete, .. }) => self.length(run),
            _ => 0.0,
        };
        after - self.controller_gate.map_or(0.0, |gate| gate.value)
    }
}
