//! What a source file imports, read from its tokens: `use` lines, and paths that stand in the code.
//!
//! Code under `#[cfg(test)]` is left out.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// A path with the line on which it stands; names of modules from the crate's root down, as in
/// `["diagnose", "stage"]`, are called module paths.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Written {
    /// As in the code: `crate`, `self` and `super` are not settled yet.
    pub(crate) path: Vec<String>,
    pub(crate) line: usize,
}

/// A name that a `use` line brings into a module; `name` is `None` for `*`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Use {
    pub(crate) name: Option<String>,
    pub(crate) written: Written,
}

/// A module: a file, or a block `mod NAME { }` in one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Module {
    pub(crate) path: Vec<String>,
    pub(crate) uses: Vec<Use>,
    pub(crate) inline: Vec<Written>,
}

/// The modules of a file whose module path is `path`, its own first.
pub(crate) fn scan(path: &[String], text: &str) -> Vec<Module> {
    let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{path:?}: {error}"));
    let mut found = vec![Module { path: path.to_vec(), ..Module::default() }];
    walk(&tokens.into_iter().collect::<Vec<_>>(), 0, &mut found);
    found
}

fn is(token: Option<&TokenTree>, word: &str) -> bool {
    match token {
        Some(TokenTree::Ident(ident)) => *ident == word,
        Some(TokenTree::Punct(punct)) => word.starts_with(punct.as_char()) && word.len() == 1,
        _ => false,
    }
}

fn is_separator(tokens: &[TokenTree], at: usize) -> bool {
    is(tokens.get(at), ":") && is(tokens.get(at + 1), ":")
}

fn group(token: Option<&TokenTree>, delimiter: Delimiter) -> Option<&Group> {
    match token {
        Some(TokenTree::Group(group)) if group.delimiter() == delimiter => Some(group),
        _ => None,
    }
}

fn inside(group: &Group) -> Vec<TokenTree> {
    group.stream().into_iter().collect()
}

/// Whether an attribute leaves what follows to tests.
fn is_of_tests(attribute: &Group) -> bool {
    let tokens = inside(attribute);
    let has = |group: &Group| group.stream().into_iter().any(|token| is(Some(&token), "test"));
    is(tokens.first(), "cfg") && group(tokens.get(1), Delimiter::Parenthesis).is_some_and(has)
}

/// Adds what these tokens import to module `own` of those found.
fn walk(tokens: &[TokenTree], own: usize, found: &mut Vec<Module>) {
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        let attribute =
            group(tokens.get(at + 1), Delimiter::Bracket).filter(|_| is(Some(token), "#"));
        if let Some(attribute) = attribute {
            at += 2;
            if is_of_tests(attribute) {
                // The item goes on to its block or its semicolon.
                let ends =
                    |token| is(Some(token), ";") || group(Some(token), Delimiter::Brace).is_some();
                at += tokens[at..].iter().position(ends).map_or(tokens.len(), |length| length + 1);
            }
        } else if is(Some(token), "use") && !is(tokens.get(at + 1), "<") {
            let end = tokens[at..].iter().position(|token| is(Some(token), ";"));
            let end = end.map_or(tokens.len(), |length| at + length);
            tree(&tokens[at + 1..end], &[], &mut found[own].uses);
            at = end + 1;
        } else if let (true, Some(TokenTree::Ident(name)), Some(block)) = (
            is(Some(token), "mod"),
            tokens.get(at + 1),
            group(tokens.get(at + 2), Delimiter::Brace),
        ) {
            let mut path = found[own].path.clone();
            path.push(name.to_string());
            found.push(Module { path, ..Module::default() });
            walk(&inside(block), found.len() - 1, found);
            at += 3;
        } else if let TokenTree::Group(group) = token {
            walk(&inside(group), own, found);
            at += 1;
        } else if let TokenTree::Ident(_) = token {
            let (path, line, end) = path(tokens, at);
            // What follows `::` or `.` belongs to something else.
            let is_start = at == 0
                || !(is(tokens.get(at - 1), ":") || is(tokens.get(at - 1), "."))
                || (is(tokens.get(at - 1), ":") && (at < 2 || !is(tokens.get(at - 2), ":")));
            if is_start && path.len() > 1 {
                found[own].inline.push(Written { path, line });
            }
            at = end;
        } else {
            at += 1;
        }
    }
}

/// The path that begins at a token, its line, and where it ends.
fn path(tokens: &[TokenTree], mut at: usize) -> (Vec<String>, usize, usize) {
    let line = tokens[at].span().start().line;
    let mut path = Vec::new();
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        path.push(name.to_string());
        at += 1;
        if !is_separator(tokens, at) || !matches!(tokens.get(at + 2), Some(TokenTree::Ident(_))) {
            break;
        }
        at += 2;
    }
    (path, line, at)
}

/// The names of a tree of `use`, which stands behind a path.
fn tree(tokens: &[TokenTree], before: &[String], uses: &mut Vec<Use>) {
    for branch in tokens.split(|token| is(Some(token), ",")).filter(|branch| !branch.is_empty()) {
        let (own, mut line, mut at) = path(branch, 0);
        let mut whole = [before, &own[..]].concat();
        if is_separator(branch, at) {
            at += 2;
        }
        if let Some(inner) = group(branch.get(at), Delimiter::Brace) {
            tree(&inside(inner), &whole, uses);
            continue;
        }
        if let Some(star) = branch.get(at).filter(|token| is(Some(token), "*")) {
            line = star.span().start().line;
            uses.push(Use { name: None, written: Written { path: whole, line } });
            continue;
        }
        if whole.len() > 1 && whole.last().is_some_and(|last| last == "self") {
            whole.pop();
        }
        let name = match branch.get(at + 1) {
            Some(alias) if is(branch.get(at), "as") => Some(alias.to_string()),
            _ => whole.last().cloned(),
        };
        uses.push(Use { name, written: Written { path: whole, line } });
    }
}

#[test]
fn imports_are_read_however_they_are_written() {
    let text = r#"
//! use crate::comment::Not;
use crate::a::{self, b::{One, Two as Second}, c::*};
pub(crate) use super::d::Three;
#[cfg(test)]
use crate::tests::Not;
fn f(x: crate::e::Four) -> &'static str {
    let y = self::g::h(x.method::<u8>());
    format!("use crate::text::Not; {}", [crate::i::J; 2].len())
}
mod block {
    use super::Inner;
}
#[cfg(test)]
mod tests {
    use crate::tests::Not;
}
"#;
    let found = scan(&["room".to_owned()], text);
    let uses = |module: &Module| -> Vec<String> {
        let one = |it: &Use| {
            let name = it.name.as_deref().unwrap_or("*");
            format!("{} = {}:{}", name, it.written.path.join("::"), it.written.line)
        };
        module.uses.iter().map(one).collect()
    };
    let expected = [
        "a = crate::a:3",
        "One = crate::a::b::One:3",
        "Second = crate::a::b::Two:3",
        "* = crate::a::c:3",
        "Three = super::d::Three:4",
    ];
    assert_eq!(uses(&found[0]), expected);
    let inline: Vec<String> = found[0].inline.iter().map(|it| it.path.join("::")).collect();
    assert_eq!(inline, ["crate::e::Four", "self::g::h", "crate::i::J"]);
    assert_eq!((found.len(), uses(&found[1])), (2, vec!["Inner = super::Inner:12".to_owned()]));
}
