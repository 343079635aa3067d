//! Pages: templates filled in, with the style and the scripts in them, so that nothing is loaded from elsewhere.

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::format::atomic;

/// The style of all pages.
pub(super) const STYLE: &str = include_str!("web/style.css");

/// Fills a template in; values are escaped as HTML unless the template says that they are safe.
pub(super) fn filled(template: &str, values: impl Serialize) -> Result<String> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment
        .render_str(template, Serde(values))
        .map_err(|error| Error::data("page", error.to_string()))
}

/// JavaScript modules as one, in the order of their use: what they import from each other is in scope.
pub(super) fn bundle(modules: &[&str]) -> String {
    let lines = modules.iter().flat_map(|text| text.lines());
    let lines = lines.filter(|line| !line.starts_with("import "));
    let lines = lines.map(|line| line.strip_prefix("export ").unwrap_or(line));
    lines.collect::<Vec<_>>().join("\n")
}

/// A value as JSON for a script element.
pub(super) fn json(value: &impl Serialize) -> Result<String> {
    let text =
        serde_json::to_string(value).map_err(|error| Error::data("page", error.to_string()))?;
    // No text in it ends the element.
    Ok(text.replace('<', "\\u003c"))
}

/// Refuses the name of an output that browsers would not take for a page.
pub fn check_ending(path: &Path) -> Result<()> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    match ending.is_some_and(|ending| {
        ["html", "htm"]
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
    }) {
        true => Ok(()),
        false => Err(Error::option(
            "output",
            path.display().to_string(),
            "a name that ends in .html",
        )),
    }
}

/// Writes a page.
pub fn write(path: &Path, page: &str) -> Result<()> {
    atomic::write_file(path, |sink| {
        use std::io::Write;
        sink.write_all(page.as_bytes())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_escaped() {
        let page = filled("<p>{{ name }}</p>", serde_json::json!({"name": "<b>&"})).unwrap();
        assert_eq!(page, "<p>&lt;b&gt;&amp;</p>");
        assert!(!json(&"</script>").unwrap().contains('<'));
    }

    #[test]
    fn modules_lose_what_joins_them() {
        let first = "export const a = 1;\nexport function f() {}";
        let second = "import { a } from \"./a.js\";\nf(a);";
        assert_eq!(
            bundle(&[first, second]),
            "const a = 1;\nfunction f() {}\nf(a);"
        );
    }
}
