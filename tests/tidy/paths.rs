//! The paths that a Rust text names outside its tests: those of `use` declarations, braces spread out, and
//! those in the code that begin with `crate`, `self` or `super`.

/// A path as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Its names.
    pub path: Vec<String>,
    /// The modules within the file that it stands in.
    pub within: Vec<String>,
    /// Whether a `use` declaration names it.
    pub in_use: bool,
}

/// What a text names.
#[derive(Debug, Default, PartialEq)]
pub struct Paths {
    /// In the order of the text.
    pub paths: Vec<Named>,
    /// Modules in files of their own that are compiled for tests alone.
    pub test_modules: Vec<String>,
}

/// Words, `::` and single other signs of a text, without comments and literals.
pub fn tokens(text: &str) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let mut found = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        let rest = &chars[at..];
        let (length, is_code) = match rest {
            ['/', '/', ..] => (until(rest, "\n"), false),
            ['/', '*', ..] => (until(rest, "*/"), false),
            ['r', '"', ..] | ['r', '#', '"', ..] => (raw_string(rest), false),
            ['"', ..] => (quoted(rest, '"'), false),
            ['\'', '\\', ..] | ['\'', _, '\'', ..] => (quoted(rest, '\''), false),
            [':', ':', ..] => (2, true),
            [first, ..] if is_word(*first) => {
                (rest.iter().take_while(|c| is_word(**c)).count(), true)
            }
            [first, ..] => (1, !first.is_whitespace()),
            [] => break,
        };
        if is_code {
            found.push(rest[..length].iter().collect());
        }
        at += length;
    }
    found
}

fn is_word(sign: char) -> bool {
    sign.is_alphanumeric() || sign == '_'
}

/// Signs up to and with `end`.
fn until(rest: &[char], end: &str) -> usize {
    let end: Vec<char> = end.chars().collect();
    let found = rest.windows(end.len()).position(|signs| signs == end);
    found.map_or(rest.len(), |at| at + end.len())
}

fn raw_string(rest: &[char]) -> usize {
    let hashes = rest[1..].iter().take_while(|c| **c == '#').count();
    let begin = 2 + hashes;
    begin + until(&rest[begin..], &format!("\"{}", "#".repeat(hashes)))
}

/// Signs of a literal between two quotes.
fn quoted(rest: &[char], quote: char) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != quote {
        at += if rest[at] == '\\' { 2 } else { 1 };
    }
    (at + 1).min(rest.len())
}

impl Paths {
    /// The paths among the tokens of a file.
    pub fn of(tokens: &[String]) -> Self {
        let mut found = Self::default();
        // The modules that are open, and how deep their braces lie.
        let mut open: Vec<(String, usize)> = Vec::new();
        let (mut at, mut depth) = (0, 0);
        while at < tokens.len() {
            let word = |ahead: usize| tokens.get(at + ahead).map_or("", String::as_str);
            let within = || open.iter().map(|(name, _)| name.clone()).collect();
            if is_test_attribute(&tokens[at..]) {
                at = found.skip_item(tokens, at + TEST.len());
                continue;
            }
            match (word(0), word(1), word(2)) {
                // `use<'a>` of a type says what it captures.
                ("use", next, _) if next != "<" => {
                    let mut reader = UseTree { tokens, at: at + 1 };
                    let paths = reader.read();
                    at = reader.at;
                    let named = |path| Named {
                        path,
                        within: within(),
                        in_use: true,
                    };
                    found.paths.extend(paths.into_iter().map(named));
                    continue;
                }
                ("mod", name, "{") => open.push((name.to_owned(), depth)),
                ("crate" | "self" | "super", "::", _) => {
                    let path = path_at(&tokens[at..]);
                    at += 2 * path.len() - 1;
                    found.paths.push(Named {
                        path,
                        within: within(),
                        in_use: false,
                    });
                    continue;
                }
                ("{", ..) => depth += 1,
                ("}", ..) => {
                    depth -= 1;
                    open.retain(|(_, outside)| *outside < depth);
                }
                _ => {}
            }
            at += 1;
        }
        found
    }

    /// Where the item that follows a test attribute ends.
    fn skip_item(&mut self, tokens: &[String], begin: usize) -> usize {
        let mut depth = 0;
        for at in begin..tokens.len() {
            match tokens[at].as_str() {
                "{" => depth += 1,
                "}" if depth == 1 => return at + 1,
                "}" => depth -= 1,
                ";" if depth == 0 => {
                    if tokens[at - 2] == "mod" {
                        self.test_modules.push(tokens[at - 1].clone());
                    }
                    return at + 1;
                }
                _ => {}
            }
        }
        tokens.len()
    }
}

const TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];

fn is_test_attribute(tokens: &[String]) -> bool {
    tokens.len() >= TEST.len() && tokens.iter().zip(TEST).all(|(token, word)| token == word)
}

/// The names at the beginning of some tokens, `::` between them.
fn path_at(tokens: &[String]) -> Vec<String> {
    let mut path = vec![tokens[0].clone()];
    for pair in tokens[1..].chunks_exact(2) {
        let is_name = pair[1].starts_with(is_word);
        if pair[0] != "::" || !is_name {
            break;
        }
        path.push(pair[1].clone());
    }
    path
}

/// A reader of what stands behind `use`.
struct UseTree<'a> {
    tokens: &'a [String],
    at: usize,
}

impl UseTree<'_> {
    fn next(&mut self) -> &str {
        let token = self.tokens.get(self.at).map_or(";", String::as_str);
        self.at += 1;
        token
    }

    /// The paths of a tree up to the `,`, `}` or `;` behind it, which is passed.
    fn read(&mut self) -> Vec<Vec<String>> {
        let mut path: Vec<String> = Vec::new();
        let mut branches: Option<Vec<Vec<String>>> = None;
        loop {
            match self.next() {
                "," | "}" | ";" => break,
                "::" | "*" => {}
                "as" => self.at += 1,
                "{" => branches = Some(self.branches()),
                name => path.push(name.to_owned()),
            }
        }
        let Some(branches) = branches else {
            return if path.is_empty() {
                Vec::new()
            } else {
                vec![path]
            };
        };
        let whole = |branch: Vec<String>| match branch[..] {
            [ref only] if only == "self" => path.clone(),
            _ => [path.clone(), branch].concat(),
        };
        branches.into_iter().map(whole).collect()
    }

    /// The trees between braces; the closing one is passed.
    fn branches(&mut self) -> Vec<Vec<String>> {
        let mut all = Vec::new();
        loop {
            all.extend(self.read());
            if self
                .tokens
                .get(self.at - 1)
                .is_none_or(|token| token != ",")
            {
                return all;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str) -> Vec<String> {
        let found = Paths::of(&tokens(text));
        let shown = |named: &Named| {
            let mark = if named.in_use { "use " } else { "" };
            let within: String = named
                .within
                .iter()
                .map(|name| format!("[{name}]"))
                .collect();
            format!("{mark}{within}{}", named.path.join("::"))
        };
        found.paths.iter().map(shown).collect()
    }

    #[test]
    fn braces_are_spread_out() {
        let text = "use crate::{a::b, c::{self, D as E, f::*}};\npub use super::super::g::{H};";
        let expected = [
            "crate::a::b",
            "crate::c",
            "crate::c::D",
            "crate::c::f",
            "super::super::g::H",
        ];
        assert_eq!(written(text), expected.map(|path| format!("use {path}")));
        assert_eq!(
            written("use a::{\n    b,\n    c,\n};\nuse d;"),
            ["use a::b", "use a::c", "use d"]
        );
    }

    #[test]
    fn paths_in_the_code_are_seen_and_comments_and_literals_are_not() {
        let text = "// crate::x\n/* super::y */ fn f<'a>(p: &'a str) -> char {\n\
                    let s = \"crate::z \\\" self::w\"; let r = r#\"crate::\"v\"#;\n\
                    crate::a::b(super::c::<u8>(), '\"', '\\'', self.d) }\n\
                    pub(crate) fn g() -> impl Fn() + use<> { super::e }";
        assert_eq!(written(text), ["crate::a::b", "super::c", "super::e"]);
    }

    #[test]
    fn what_tests_name_is_left_out() {
        let text = "use crate::a;\n#[cfg(test)]\nmod oracle;\nuse crate::b;\n\
                    #[cfg(test)]\nmod tests { use super::*; fn f() { crate::c::d() } }\nuse crate::e;";
        assert_eq!(
            written(text),
            ["use crate::a", "use crate::b", "use crate::e"]
        );
        assert_eq!(Paths::of(&tokens(text)).test_modules, ["oracle"]);
    }

    #[test]
    fn modules_within_a_file_are_told() {
        let text = "mod inner { use super::A; fn f() { super::b() } }\nfn g() { self::c() }";
        assert_eq!(
            written(text),
            ["use [inner]super::A", "[inner]super::b", "self::c"]
        );
    }
}
