//! Text to trees and back, and what is said of text that is no formula.

use homepoint::diagnostic::Source;
use homepoint::formula::error::{DEPTH_LIMIT, LENGTH_LIMIT};
use homepoint::formula::functions::TABLE;
use homepoint::formula::{Expression, ExpressionKind, Formula};
use proptest::prelude::*;

use crate::bench::formula;

/// The tree with every pair of parentheses written.
fn shape(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number(value, unit) => {
            format!("{value}{}", unit.as_ref().map_or("", |_| "u"))
        }
        ExpressionKind::Name(name) => name.clone(),
        ExpressionKind::Member(of, axis) => format!("{}.{axis:?}", shape(of)),
        ExpressionKind::Vector(parts) => format!("[{}]", parts.each_ref().map(shape).join(" ")),
        ExpressionKind::Negate(of) => format!("(-{})", shape(of)),
        ExpressionKind::Binary(operator, a, b) => {
            format!("({operator:?} {} {})", shape(a), shape(b))
        }
        ExpressionKind::Call(function, arguments) => {
            let arguments: Vec<String> = arguments.iter().map(shape).collect();
            format!("{function}<{}>", arguments.join(" "))
        }
    }
}

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, expected) in [
        ("a - b - c", "(Subtract (Subtract a b) c)"),
        ("a + b * c / d", "(Add a (Divide (Multiply b c) d))"),
        ("a ^ b ^ c", "(Power a (Power b c))"),
        ("-a^2", "(-(Power a 2))"),
        ("-a * b", "(Multiply (-a) b)"),
        ("a^-b * c", "(Multiply (Power a (-b)) c)"),
        ("2^-3^x", "(Power 2 (-(Power 3 x)))"),
        ("a - -b", "(Subtract a (-b))"),
        ("(a + b).x", "(Add a b).X"),
        ("horizontal.delay + point.x", "(Add horizontal.delay point.X)"),
        ("x.delay * x", "(Multiply x.delay x)"),
        ("[a, b, c].z", "[a b c].Z"),
        ("atan2(y, -x)", "atan2<y (-x)>"),
        ("1e-3 * .5 + 2.5E2", "(Add (Multiply 0.001 0.5) 250)"),
        ("3 mm * k", "(Multiply 0.003u k)"),
        ("2 min", "120u"),
        ("9.81 m/s^2 * k", "(Multiply 9.81u k)"),
        ("3 N m / k", "(Divide 3u k)"),
        ("3 N m/rad", "3u"),
        ("2 m / h", "(Divide 2u h)"),
        ("2 rad/(s^2*K)", "2u"),
        ("5 % * k", "(Multiply 0.05u k)"),
        ("1 deg*t", "(Multiply 0.017453292519943295u t)"),
        ("1 arcsec/cos(a)", "(Divide 0.00000484813681109536u cos<a>)"),
        ("-2 degC", "271.15u"),
    ] {
        assert_eq!(shape(&formula(text).root), expected, "{text}");
    }
}

#[test]
fn every_span_covers_the_text_it_came_from() {
    let parsed = formula("1 + rotate(q,  [a, b.c, -d]).x");
    let ExpressionKind::Binary(_, _, right) = &parsed.root.kind else {
        unreachable!("a sum was written");
    };
    let cut = |e: &Expression| parsed.text[e.span.start..e.span.end].to_owned();
    assert_eq!(cut(right), "rotate(q,  [a, b.c, -d]).x");
    let ExpressionKind::Member(call, _) = &right.kind else {
        unreachable!("a member was written");
    };
    assert_eq!(cut(call), "rotate(q,  [a, b.c, -d])");
    let ExpressionKind::Call(_, arguments) = &call.kind else {
        unreachable!("a call was written");
    };
    assert_eq!(arguments.iter().map(cut).collect::<Vec<_>>(), ["q", "[a, b.c, -d]"]);
}

#[test]
fn faults_say_where_what_and_what_to_do() {
    let file = "title = 'é'\nvalue = '@'\n";
    let messages: Vec<String> = [
        "",
        "a +",
        "a b",
        "(a",
        "[a, b]",
        "sni(a)",
        "sin",
        "atan2(a)",
        "min()",
        "2 parsec",
        "a.b.",
        "(a).w",
        "a $ b",
        "1e999",
        "3 m q",
        "3 m^2",
        "f(a",
        "a, b",
        "*",
        "sin(a)(b)",
        "\u{1F600}",
    ]
    .iter()
    .map(|text| {
        let source = Source::new("model.toml", file.replace('@', text));
        let fault = Formula::parse(source, file.find('@').unwrap(), text).unwrap_err();
        format!("{text:?}\n{fault}")
    })
    .collect();
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn deep_and_long_texts_are_refused_not_followed() {
    for (text, word) in [
        ("(".repeat(LENGTH_LIMIT), "deep"),
        ("(".repeat(100_000), "long"),
        ("-".repeat(15_000), "deep"),
        (format!("a{}", "^a".repeat(5_000)), "deep"),
        (format!("a{}", "+a".repeat(5_000)), "deep"),
        (format!("a{}", ".x".repeat(5_000)), "deep"),
        (format!("(a){}", ".x".repeat(5_000)), "deep"),
        ("sin(".repeat(4_000), "deep"),
        ("[".repeat(4_000), "deep"),
    ] {
        let fault = Formula::parse_text("test", &text).unwrap_err();
        assert!(fault.message.contains(word), "{}", fault.message);
    }
    let widest = format!("a{}", "+a".repeat(DEPTH_LIMIT - 1));
    assert!(Formula::parse_text("test", &widest).is_ok());
}

#[test]
fn the_table_of_functions_is_in_the_order_of_its_enum() {
    for entry in TABLE {
        assert_eq!(entry.function.entry().name, entry.name);
        assert!(entry.signature.starts_with(entry.name) && entry.about.ends_with('.'));
    }
}

#[test]
fn formulas_are_shown_as_equations() {
    let shown: Vec<String> = [
        "atan2(hypot(point.x, point.y), point.z)",
        "rotate(orientation * inverse(arm_turn), [radius, 0, -20 arcsec]) + position",
        "(a + b) * (c - (d - e)) / -f^2",
        "rate(rate(arm_angle)) - rate(horizontal)^2 * rate(sin(a))",
        "dot(a, cross(b, c)) * norm(v) + sqrt(abs(x)) / 2.5e-7",
        "-(a - b) + (-a)^2 - (2 m)^-0.5 + horizontal.delay / pi",
    ]
    .iter()
    .map(|text| format!("{}\n    {}", formula(text).to_text(), formula(text).to_latex()))
    .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

fn expressions() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        "[a-d]",
        Just("point.x".to_owned()),
        Just("20 arcsec".to_owned()),
        Just("0.1 degC".to_owned()),
        (0u32..2000).prop_map(|n| (f64::from(n) / 16.0).to_string()),
    ];
    leaf.prop_recursive(5, 40, 4, |inner| {
        let pair =
            (inner.clone(), prop::sample::select(vec!["+", "-", "*", "/", "^"]), inner.clone());
        prop_oneof![
            pair.prop_map(|(a, o, b)| format!("({a}){o}({b})")),
            inner.clone().prop_map(|a| format!("-({a})")),
            inner.clone().prop_map(|a| format!("({a}).y")),
            inner.clone().prop_map(|a| format!("sin({a})")),
            [inner.clone(), inner.clone(), inner].prop_map(|v| format!("[{}]", v.join(","))),
        ]
    })
}

proptest! {
    #[test]
    fn arbitrary_text_never_panics(text in "\\PC{0,60}") {
        let _ = Formula::parse_text("test", &text);
    }

    #[test]
    fn arbitrary_words_never_panic(
        words in prop::collection::vec(prop::sample::select(vec![
            "a", "x", ".", "point.x", "1", "1e", "2.", "m", "degC", "(", ")", "[", "]", ",", "+", "-", "*",
            "/", "^", "sin", "rate(", "é", " ",
        ]), 0..40)
    ) {
        let text = words.concat();
        match Formula::parse_text("test", &text) {
            Ok(parsed) => {
                let again = Formula::parse_text("test", &parsed.to_text()).unwrap();
                prop_assert_eq!(shape(&again.root), shape(&parsed.root));
            }
            Err(fault) => prop_assert!(fault.place.is_some()),
        }
    }

    #[test]
    fn shown_text_means_the_same(text in expressions()) {
        let parsed = formula(&text);
        let again = formula(&parsed.to_text());
        prop_assert_eq!(again.to_text(), parsed.to_text());
        prop_assert_eq!(shape(&again.root), shape(&parsed.root), "{}", parsed.to_text());
        prop_assert!(!parsed.to_latex().is_empty());
    }
}
