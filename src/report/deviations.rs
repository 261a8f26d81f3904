//! The result of `deviations`: what it prints, its JSON and its table.

use serde_json::{Map, Value, json};

use crate::campaign::specification::{SPEEDS, Specification};
use crate::campaign::stamps;
use crate::engine::Problem;
use crate::estimate::circle::{Circle, NoCircle};
use crate::estimate::deviations::{NoDeviations, RunDeviations, Spread};
use crate::estimate::head::{AngleMotion, Head, Largest};
use crate::estimate::intersection::Intersection;
use crate::report::json::number;
use crate::report::table::quoted;
#[cfg(feature = "cli")]
use crate::units::decimal;

/// Names of the three deviations.
const CHANNELS: [&str; 3] = ["planar", "radial", "tangential"];

/// What one run shows.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What its head must follow.
    pub head: Head,
    /// Its deviations, or why it has none.
    pub found: Result<RunDeviations, NoDeviations>,
    /// Whether the lines of sight meet, for a model that can tell.
    pub gap: Option<Intersection>,
}

/// All runs of a campaign, with what they are held against.
#[derive(Clone, Copy, Debug)]
pub struct Whole<'a> {
    /// The campaigns.
    pub problem: &'a Problem,
    /// The campaign.
    pub part: usize,
    /// What its instrument is said to follow.
    pub specification: &'a Specification,
    /// One for each run.
    pub runs: &'a [Shown],
}

impl Whole<'_> {
    fn run_name(&self, run: usize) -> &str {
        &self.problem.parts[self.part].runs[run].name
    }

    fn measurand(&self, measurand: usize) -> &str {
        &self.problem.parts[self.part].system.assembly.names.measurands[measurand].name
    }
}

/// The result for programs.
pub fn json(whole: Whole<'_>) -> Value {
    let runs: Vec<Value> = whole
        .runs
        .iter()
        .enumerate()
        .map(|(run, Shown { head, found, gap })| {
            let mut value = json!({
                "run": whole.run_name(run),
                "head": head_json(whole, run, head),
                "speeds": speeds_json(whole, head),
            });
            let more = match found {
                Ok(found) => found_json(whole, found, gap.as_ref()),
                Err(why) => json!({ "left_out": why.to_string() }),
            };
            if let (Value::Object(into), Value::Object(more)) = (&mut value, more) {
                into.extend(more);
            }
            value
        })
        .collect();
    json!({ "runs": runs })
}

fn found_json(whole: Whole<'_>, found: &RunDeviations, gap: Option<&Intersection>) -> Value {
    let frame = |spreads: &[Spread; 3]| -> Value {
        let entries = CHANNELS.iter().zip(spreads);
        let entries = entries.map(|(name, one)| ((*name).to_owned(), spread_json(one)));
        Value::Object(entries.collect::<Map<_, _>>())
    };
    let by_direction: Map<String, Value> = found
        .by_direction
        .iter()
        .map(|one| {
            let value = json!({
                "growing": one.growing,
                "falling": one.falling,
                "difference": one.growing - one.falling,
                "sigma": one.sigma,
            });
            (whole.measurand(one.measurand).to_owned(), value)
        })
        .collect();
    json!({
        "samples": found.samples.len(),
        "radius": found.radius,
        "arm_rate": number(Some(found.arm_rate)),
        "delay": number(found.delay()),
        "arm_frame": frame(&found.in_arm_frame),
        "circle_frame": found.in_circle_frame.as_ref().map_or(Value::Null, frame),
        "circle": circle_json(&found.circle),
        "gap": gap.map_or(Value::Null, gap_json),
        "tangential_by_direction": by_direction,
    })
}

fn gap_json(gap: &Intersection) -> Value {
    let [as_read, without_delays] = gap.spreads.each_ref().map(spread_json);
    json!({ "as_read": as_read, "without_delays": without_delays, "expected": gap.expected })
}

fn spread_json(one: &Spread) -> Value {
    json!({
        "mean": number(Some(one.mean)),
        "deviation": number(Some(one.deviation)),
        "minimum": number(Some(one.minimum)),
        "maximum": number(Some(one.maximum)),
    })
}

fn circle_json(circle: &Result<Circle, NoCircle>) -> Value {
    let circle = match circle {
        Ok(circle) => circle,
        Err(why) => return json!({ "left_out": why.to_string() }),
    };
    let rows = |matrix: Option<nalgebra::Matrix3<f64>>| {
        matrix.map(|m| {
            m.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>()
        })
    };
    json!({
        "centre": circle.centre,
        "centre_covariance": rows(circle.centre_covariance()),
        "normal": circle.normal,
        "normal_covariance": rows(circle.normal_covariance()),
        "radius": circle.radius,
        "radius_sigma": number(circle.radius_uncertainty()),
        "points": circle.points,
    })
}

/// The arm angle of a sample (rad), if its run has one.
fn arm_angle(whole: Whole<'_>, run: usize, sample: usize) -> Option<f64> {
    let found = whole.runs[run].found.as_ref().ok()?;
    let at = found.samples.binary_search_by_key(&sample, |one| one.sample).ok()?;
    Some(found.samples[at].arm_angle)
}

fn largest_json(largest: Option<Largest>, limit: Option<f64>) -> Value {
    let value = largest.map(|one| one.value);
    let within = value.zip(limit).map(|(value, limit)| value <= limit);
    json!({ "largest": number(value), "limit": limit, "within": within })
}

fn head_json(whole: Whole<'_>, run: usize, head: &Head) -> Value {
    let one = |angle: &AngleMotion| {
        let name = whole.measurand(angle.measurand);
        let mut value = largest_json(angle.largest, whole.specification.rate(name));
        let at = angle.largest.and_then(|largest| arm_angle(whole, run, largest.sample));
        let reversals = angle.reversals.as_ref().map(|list| {
            let word = |grows| if grows { "growing" } else { "falling" };
            list.iter()
                .map(|one| json!({ "arm_angle": one.arm_angle, "then": word(one.grows_after), "count": one.count }))
                .collect::<Vec<_>>()
        });
        if let Value::Object(map) = &mut value {
            map.insert("at_arm_angle".to_owned(), number(at));
            map.insert("reversals".to_owned(), json!(reversals));
        }
        (name.to_owned(), value)
    };
    Value::Object(head.angles.iter().map(one).collect::<Map<_, _>>())
}

fn speeds_json(whole: Whole<'_>, head: &Head) -> Value {
    let limits = whole.specification.speeds.iter().map(|one| one.as_ref().map(|one| one.value));
    let entries = SPEEDS
        .iter()
        .zip(head.largest_speeds)
        .zip(limits)
        .map(|((name, largest), limit)| ((*name).to_owned(), largest_json(largest, limit)));
    Value::Object(entries.collect::<Map<_, _>>())
}

/// One row a sample: run, row of its data file, time, arm angle, deviations in both frames, rates
/// of the head's angles, speeds of the target, the point from the readings, the gap where there is
/// one.
pub fn table(whole: Whole<'_>) -> String {
    let mut text = String::from("run,row,time [s],arm_angle [rad]");
    for frame in ["arm", "circle"] {
        for channel in CHANNELS {
            text.push_str(&format!(",{frame}_{channel} [m]"));
        }
    }
    let angles: Vec<&str> = whole
        .runs
        .first()
        .map(|run| run.head.angles.iter().map(|one| whole.measurand(one.measurand)).collect())
        .unwrap_or_default();
    for name in angles {
        text.push_str(&format!(",{name}_rate [rad/s]"));
    }
    for name in SPEEDS {
        text.push_str(&format!(",{name} [m/s]"));
    }
    text.push_str(",x [m],y [m],z [m]");
    if whole.runs.iter().any(|run| run.gap.is_some()) {
        text.push_str(",gap [m],gap_without_delays [m]");
    }
    text.push('\n');
    for (run, Shown { head, found, gap }) in whole.runs.iter().enumerate() {
        let Ok(found) = found else { continue };
        let gaps = gap.as_ref().map(|gap| [&gap.as_read, &gap.without_delays]);
        let part = &whole.problem.parts[whole.part];
        let (data, zero) = (&part.runs[run], part.zero);
        let samples = data.record.whole();
        for one in &found.samples {
            let k = one.sample;
            let row = samples.rows.get(k).copied().unwrap_or(k + 1);
            text.push_str(&format!(
                "{},{row},{},{:.9}",
                quoted(&data.name),
                stamps::written(zero, samples.time[k]),
                one.arm_angle
            ));
            let rates = head.angles.iter().map(|angle| angle.rates[k]);
            let speeds = head.speeds.iter().filter_map(|speeds| speeds.get(k).copied());
            for value in one.arm.into_iter().chain(one.circle).chain(rates).chain(speeds) {
                if value.is_finite() {
                    text.push_str(&format!(",{value:.6e}"));
                } else {
                    text.push(',');
                }
            }
            for value in one.point.iter().chain(gaps.iter().flatten().map(|gaps| &gaps[k])) {
                text.push_str(&format!(",{value:.9e}"));
            }
            text.push('\n');
        }
    }
    text
}

/// The result for people.
#[cfg(feature = "cli")]
pub fn text(title: &str, from: crate::estimate::transformation::From, whole: Whole<'_>) -> String {
    use crate::report::layout::{align_right, drawn, table};
    use crate::report::text::from_words;
    let mut text = format!("{title}\ntransformation from {}\n", from_words(from));
    let mut rows = table(&["run", "arm", "frame", "deviation", "mean", "deviation", "from", "to"]);
    for (run, shown) in whole.runs.iter().enumerate() {
        let Ok(found) = &shown.found else { continue };
        let frames = [("arm", Some(found.in_arm_frame)), ("circle", found.in_circle_frame)];
        for (frame, spreads) in frames {
            for (channel, one) in CHANNELS.iter().zip(spreads.iter().flatten()) {
                let cells = [one.mean, one.deviation, one.minimum, one.maximum].map(micrometres);
                let [mean, deviation, low, high] = cells;
                let name = whole.run_name(run).to_owned();
                let rate = format!("{:.1} deg/s", found.arm_rate.to_degrees());
                rows.add_row([
                    name,
                    rate,
                    frame.into(),
                    (*channel).into(),
                    mean,
                    deviation,
                    low,
                    high,
                ]);
            }
        }
    }
    if whole.runs.iter().any(|shown| shown.found.is_ok()) {
        align_right(&mut rows, &[1, 4, 5, 6, 7]);
        text.push('\n');
        text.push_str(&drawn(&rows));
    }
    for (run, shown) in whole.runs.iter().enumerate() {
        text.push_str(&run_text(whole, run, shown));
    }
    text.push('\n');
    text
}

#[cfg(feature = "cli")]
fn micrometres(metres: f64) -> String {
    // Adding zero takes the sign of what rounds to none.
    format!("{} µm", decimal((metres * 1e7).round() / 10.0 + 0.0, 1))
}

/// A run's circle, head and target in sentences.
#[cfg(feature = "cli")]
fn run_text(whole: Whole<'_>, run: usize, Shown { head, found, gap }: &Shown) -> String {
    use crate::report::figure::measured;
    use crate::units::{Dimension, Unit};
    let metre = Unit::coherent(Dimension::LENGTH);
    let mut text = format!("\n{}\n", whole.run_name(run));
    match found {
        Err(why) => text.push_str(&format!("  no deviations: {why}\n")),
        Ok(found) => {
            match &found.circle {
                Err(why) => text.push_str(&format!("  no circle: {why}\n")),
                Ok(circle) => {
                    let sigma = circle.radius_uncertainty().unwrap_or(f64::NAN);
                    let radius = measured(circle.radius, sigma, &metre);
                    text.push_str(&format!(
                        "  circle of {} points: radius {radius}\n",
                        circle.points
                    ));
                }
            }
            if let Some(delay) = found.delay() {
                let mean = micrometres(found.in_arm_frame[2].mean);
                let delay = delay * 1e6;
                text.push_str(&format!(
                    "  mean tangential {mean}: as a delay of {} µs\n",
                    decimal(delay, 1)
                ));
            }
            if let Some(gap) = gap {
                let [read, out] = gap.spreads.map(|one| {
                    format!("{} ± {}", micrometres(one.mean), micrometres(one.deviation))
                });
                let expected = micrometres(gap.expected);
                text.push_str(&format!(
                    "  lines of sight miss each other by {read} as read, {out} with the delays taken out; ± {expected} expected\n"
                ));
            }
            for one in &found.by_direction {
                let difference = measured(one.growing - one.falling, one.sigma, &metre);
                text.push_str(&format!(
                    "  mean tangential {} while `{m}` grows, {} while it falls: difference {difference}\n",
                    micrometres(one.growing),
                    micrometres(one.falling),
                    m = whole.measurand(one.measurand),
                ));
            }
        }
    }
    for angle in &head.angles {
        let name = whole.measurand(angle.measurand);
        if let Some(largest) = angle.largest {
            let limit = whole.specification.rate(name);
            let said = against(largest.value, limit, "rad/s");
            text.push_str(&format!(
                "  `{name}` turns at {} rad/s at most{said}",
                decimal(largest.value, 4)
            ));
        }
        if let Some(reversals) = angle.reversals.as_ref().filter(|list| !list.is_empty()) {
            let places: Vec<String> =
                reversals.iter().map(|one| format!("{:.2}", one.arm_angle.to_degrees())).collect();
            text.push_str(&format!("; reverses at arm angles {} deg", places.join(", ")));
        }
        text.push('\n');
    }
    let words = ["target", "target across the line of sight", "target along the line of sight"];
    for ((word, largest), limit) in
        words.iter().zip(head.largest_speeds).zip(&whole.specification.speeds)
    {
        if let Some(largest) = largest {
            let said = against(largest.value, limit.as_ref().map(|one| one.value), "m/s");
            text.push_str(&format!("  {word}: {} m/s at most{said}\n", decimal(largest.value, 4)));
        }
    }
    text
}

#[cfg(feature = "cli")]
fn against(value: f64, limit: Option<f64>, unit: &str) -> String {
    limit.map_or_else(String::new, |limit| {
        let word = if value <= limit { "within" } else { "beyond" };
        format!(", {word} the stated {limit:.4} {unit}")
    })
}
