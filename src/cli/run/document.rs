//! A TOML text → its sections and keys, each with its line.

use std::ops::Range;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::cli::run::faults::{Faults, Place};

/// One key of a section, or of the top of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: String,
    /// Its line, from 1.
    pub line: usize,
    /// What it is set to.
    pub value: Value,
    /// Where `[matrix]` set it: its key and the value of this run, as a fault names them.
    pub varied: Option<String>,
}

impl Key {
    /// Where it is, as a fault names it; `name` is what the key is called with its section.
    fn place_as(&self, name: String) -> Place {
        Place::new(self.line, self.varied.clone().unwrap_or(name))
    }

    /// Where a key of the top of the scene is.
    pub fn place(&self) -> Place {
        self.place_as(self.name.clone())
    }
}

/// A `[section]`, or one of several `[[sections]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its name.
    pub name: String,
    /// Its line, from 1.
    pub line: usize,
    /// Whether it was written as one of a list.
    pub listed: bool,
    /// Its keys, in alphabetical order.
    pub keys: Vec<Key>,
}

impl Section {
    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// Sets a key; one that is new stands where the section does.
    pub fn set(&mut self, name: &str, value: Value) {
        match self.keys.iter_mut().find(|key| key.name == name) {
            Some(key) => key.value = value,
            None => self.add(Key {
                name: name.to_owned(),
                line: self.line,
                value,
                varied: None,
            }),
        }
    }

    /// Where a key of this section is, for a fault.
    pub fn place(&self, key: &Key) -> Place {
        key.place_as(format!("[{}] {}", self.name, key.name))
    }

    /// Adds a key that is not there yet.
    pub fn add(&mut self, key: Key) {
        self.keys.push(key);
        self.keys.sort_by(|a, b| a.name.cmp(&b.name));
    }

    /// Where the section itself is.
    pub fn head(&self) -> Place {
        Place::new(self.line, format!("[{}]", self.name))
    }
}

/// A whole text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// Keys above the first section.
    pub keys: Vec<Key>,
    /// The sections, in the order of the text.
    pub sections: Vec<Section>,
}

impl Document {
    /// Parses a text; every fault of its form is named.
    pub fn parse(text: &str, faults: &mut Faults) -> Self {
        // Read the text, and say what is wrong with it.
        let line_of =
            |span: Range<usize>| 1 + text[..span.start.min(text.len())].matches('\n').count();
        let (spans, errors) = DeTable::parse_recoverable(text);
        for error in &errors {
            let line = error.span().map_or(0, line_of);
            faults.data(&Place::new(line, ""), error.message());
        }
        let Ok(values) = text.parse::<Table>() else {
            if errors.is_empty() {
                faults.data(&Place::new(0, ""), "no TOML");
            }
            return Self::default();
        };
        // Sort keys and sections, each with its line.
        let mut document = Self::default();
        for (key, spanned) in spans.get_ref() {
            let name = key.get_ref().to_string();
            let Some(value) = values.get(&name) else {
                continue;
            };
            let line = line_of(key.span());
            match (spanned.get_ref(), value) {
                (DeValue::Table(spans), Value::Table(values)) => {
                    let keys = keys_of(spans, values, line_of);
                    let listed = false;
                    document.sections.push(Section {
                        name,
                        line,
                        listed,
                        keys,
                    });
                }
                (DeValue::Array(spans), Value::Array(values)) if is_list_of_tables(values) => {
                    let sections = spans.iter().zip(values);
                    document
                        .sections
                        .extend(sections.filter_map(|(spanned, value)| {
                            listed_section(&name, spanned, value, line_of)
                        }));
                }
                _ => document.keys.push(Key {
                    name,
                    line,
                    value: value.clone(),
                    varied: None,
                }),
            }
        }
        document.sections.sort_by_key(|section| section.line);
        document
    }
}

fn is_list_of_tables(values: &[Value]) -> bool {
    !values.is_empty() && values.iter().all(Value::is_table)
}

fn listed_section(
    name: &str,
    spanned: &Spanned<DeValue<'_>>,
    value: &Value,
    line_of: impl Fn(Range<usize>) -> usize,
) -> Option<Section> {
    let (DeValue::Table(spans), Value::Table(values)) = (spanned.get_ref(), value) else {
        return None;
    };
    Some(Section {
        name: name.to_owned(),
        line: line_of(spanned.span()),
        listed: true,
        keys: keys_of(spans, values, line_of),
    })
}

fn keys_of(
    spans: &DeTable<'_>,
    values: &Table,
    line_of: impl Fn(Range<usize>) -> usize,
) -> Vec<Key> {
    let key = |(key, _): (&Spanned<_>, _)| {
        let name: &std::borrow::Cow<'_, str> = key.get_ref();
        Some(Key {
            name: name.to_string(),
            line: line_of(key.span()),
            value: values.get(name.as_ref())?.clone(),
            varied: None,
        })
    };
    let mut keys: Vec<Key> = spans.iter().filter_map(key).collect();
    keys.sort_by(|a, b| a.name.cmp(&b.name));
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_sections_know_their_lines() {
        let text = "name = \"a\"\n\n[knn]\nk = 4\n\n[[render]]\nframes = 2\n[[render]]\n";
        let mut faults = Faults::default();
        let document = Document::parse(text, &mut faults);
        assert!(faults.is_empty());
        assert_eq!(
            (document.keys[0].name.as_str(), document.keys[0].line),
            ("name", 1)
        );
        let heads: Vec<_> = document
            .sections
            .iter()
            .map(|s| (s.name.as_str(), s.line, s.listed))
            .collect();
        assert_eq!(
            heads,
            [("knn", 3, false), ("render", 6, true), ("render", 8, true)]
        );
        assert_eq!(document.sections[0].key("k").map(|key| key.line), Some(4));
    }

    #[test]
    fn every_fault_of_form_is_named() {
        let mut faults = Faults::default();
        Document::parse("a = \nb = 2\nc = = 3\n", &mut faults);
        let text = faults
            .into_result(std::path::Path::new("s"))
            .unwrap_err()
            .to_string();
        assert!(text.contains("line 1") && text.contains("line 3"), "{text}");
    }
}
