//! The functions of a text as rustfmt lays it out, and how many lines each has beside its comments.

use regex_lite::Regex;

/// A function with a body of several lines.
#[derive(Debug, PartialEq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Its lines, from `fn` to the closing brace, comments left out.
    pub lines: usize,
}

/// All of them. A body ends at the brace that stands as far to the right as the line with `fn` begins.
pub fn of(text: &str) -> Vec<Function> {
    let begin = Regex::new(r#"^( *)(?:[a-z]+(?:\([a-z: ]+\))? |extern "C" )*fn (\w+)"#).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let function = |(at, line): (usize, &&str)| {
        let found = begin.captures(line)?;
        let [indent, name] = [1, 2].map(|group| found.get(group).unwrap().as_str());
        Some(Function {
            name: name.to_owned(),
            lines: length(&lines[at..], indent)?,
        })
    };
    lines.iter().enumerate().filter_map(function).collect()
}

/// The lines of a function at the beginning of others; `None` for one without a body, or on one line.
fn length(lines: &[&str], indent: &str) -> Option<usize> {
    if lines[0].ends_with([';', '}']) {
        return None;
    }
    let own = |line: &&str| line.strip_prefix(indent).unwrap_or(" ").to_owned();
    let end = lines[1..].iter().map(own).position(|line| {
        let is_declared = line.starts_with(')') && line.ends_with(';');
        line == "}" || is_declared
    })?;
    let is_body = lines[end + 1].trim_start() == "}";
    let comments = lines[..=end]
        .iter()
        .filter(|line| line.trim_start().starts_with("//"));
    is_body.then(|| end + 2 - comments.count())
}

#[test]
fn functions_are_found_by_their_layout() {
    let text = "pub(super) fn a<T>(\n    b: T,\n) -> T {\n    // Step.\n    if c {\n        d\n    }\n}\n\
                trait E {\n    fn f(&self);\n    fn g(\n        h: u8,\n    ) -> u8;\n    const fn i() {\n    }\n}\n\
                fn j() {}\n// fn k() {\n";
    let found: Vec<(String, usize)> = of(text).into_iter().map(|f| (f.name, f.lines)).collect();
    assert_eq!(found, [("a".to_owned(), 7), ("i".to_owned(), 2)]);
}
