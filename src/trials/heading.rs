//! The first line of a file of trials: of what they are, so that anyone can make them again.
//!
//! The plan is data. Files written before hold it as text, the strata one after the other
//! (`one Between(2.0, 100.0) 0.2500; ...`); both forms are read.

use serde::{Deserialize, Serialize};

use super::design::Design;
use super::plan::{Kind, Order, Plan, Size, Stratum};

/// Of what the trials of a file are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heading {
    /// Seed of the plan.
    pub seed: u64,
    /// The plan.
    pub plan: Written,
    /// Models, times, inputs, noise, effects and truth of the campaign, as 16 hexadecimal digits.
    pub design: String,
    /// Version of the program that diagnosed.
    #[serde(default)]
    pub version: String,
}

/// A plan as a file has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Written {
    /// As data.
    Data {
        /// How trials take their strata.
        order: Order,
        /// The strata.
        strata: Vec<Stratum>,
    },
    /// As text: kind, size and weight of each stratum.
    Text(String),
}

impl Heading {
    /// Of a plan on a design.
    pub fn of(plan: &Plan, design: &Design) -> Self {
        Self {
            seed: plan.seed,
            plan: Written::Data { order: plan.order, strata: plan.strata.clone() },
            design: format!("{:016x}", design.stamp()),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// The plan, with so many trials; `None` where its text cannot be read.
    pub fn plan(&self, trials: usize) -> Option<Plan> {
        let (order, strata) = match &self.plan {
            Written::Data { order, strata } => (*order, strata.clone()),
            Written::Text(text) => (Order::Spread, strata(text)?),
        };
        Some(Plan { trials, seed: self.seed, order, strata })
    }

    /// What of it is not that of another heading; `None` where they agree.
    pub fn differs_from(&self, other: &Self) -> Option<&'static str> {
        if self.seed != other.seed {
            Some("seed")
        } else if self.version != other.version {
            Some("version of homepoint")
        } else if self.design != other.design {
            Some("campaign or library")
        } else {
            (self.plan(0).is_none() || self.plan(0) != other.plan(0)).then_some("plan")
        }
    }
}

/// Reads strata written as text.
fn strata(text: &str) -> Option<Vec<Stratum>> {
    // The text does not say which strata are of the mix: those of the standard plan.
    let standard = Plan::standard(0, 0).strata;
    if text == written(&standard) {
        return Some(standard);
    }
    text.split("; ").map(stratum).collect()
}

fn written(strata: &[Stratum]) -> String {
    let stratum = |one: &Stratum| format!("{} {:?} {:.4}", one.kind.word(), one.size, one.weight);
    strata.iter().map(stratum).collect::<Vec<_>>().join("; ")
}

/// Reads `kind Fixed(size) weight` or `kind Between(from, to) weight`.
fn stratum(text: &str) -> Option<Stratum> {
    let (kind, rest) = text.split_once(' ')?;
    let (size, weight) = rest.rsplit_once(' ')?;
    let kind: Kind = serde_json::from_value(kind.into()).ok()?;
    let (form, numbers) = size.strip_suffix(')')?.split_once('(')?;
    let numbers: Vec<f64> =
        numbers.split(", ").map(|one| one.parse().ok()).collect::<Option<_>>()?;
    let size = match (form, numbers.as_slice()) {
        ("Fixed", [size]) => Size::Fixed(*size),
        ("Between", [from, to]) => Size::Between(*from, *to),
        _ => return None,
    };
    Some(Stratum::new(kind, size, weight.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDARD: &str = "none Between(2.0, 100.0) 0.1500; one Between(2.0, 100.0) 0.2500; withheld Between(2.0, 100.0) 0.1000; noise Fixed(0.0) 0.3200; one Fixed(8.0) 0.0300; one Fixed(12.0) 0.0300; one Fixed(25.0) 0.0300; two Fixed(25.0) 0.0300; withheld Fixed(12.0) 0.0100; withheld Fixed(25.0) 0.0250; withheld Fixed(50.0) 0.0250";

    fn heading(plan: Written) -> Heading {
        Heading { seed: 7, plan, design: "0".to_owned(), version: String::new() }
    }

    #[test]
    fn a_plan_written_as_text_is_read() {
        let read = heading(Written::Text(STANDARD.to_owned())).plan(9400);
        assert_eq!(read, Some(Plan::standard(9400, 7)));
        let own = Plan::of(20, 7, &[Kind::Two, Kind::Withheld], &[8.0, 25.0]);
        let read = heading(Written::Text(written(&own.strata))).plan(20);
        assert_eq!(read, Some(own));
        for wrong in ["", "one", "one Fixed(x) 1.0", "nothing Fixed(1.0) 1.0", "one Fixed(1.0)"] {
            assert_eq!(heading(Written::Text(wrong.to_owned())).plan(1), None, "{wrong}");
        }
    }

    #[test]
    fn a_plan_comes_back_from_json() {
        for plan in [Plan::standard(5, 7), Plan::situations(5, 7), Plan::mixtures(5, 7)] {
            let data = Written::Data { order: plan.order, strata: plan.strata.clone() };
            let text = serde_json::to_string(&heading(data)).unwrap_or_default();
            let read = serde_json::from_str::<Heading>(&text).ok().and_then(|one| one.plan(5));
            assert_eq!(read, Some(plan), "{text}");
        }
    }

    #[test]
    fn a_plan_is_the_same_as_text_and_as_data() {
        let plan = Plan::standard(1, 7);
        let data = heading(Written::Data { order: plan.order, strata: plan.strata });
        let text = heading(Written::Text(STANDARD.to_owned()));
        assert_eq!(text.differs_from(&data), None);
        let other = heading(Written::Text("one Fixed(8.0) 1.0".to_owned()));
        assert_eq!(other.differs_from(&data), Some("plan"));
    }
}
