//! Options that the method does not use are refused: those of other methods, and shared ones that it has something else
//! in place of.

use crate::error::{Error, Result};
use crate::synthesis::method::SharedOption;
use crate::synthesis::options::SynthesisOptions;

impl SynthesisOptions {
    /// Refuses the first option of another method that was given.
    pub fn refuse_foreign(&self, is_given: impl Fn(&str) -> bool) -> Result<()> {
        for (owner, own) in self.own_options() {
            let mut names = own.changed().into_iter().map(|(name, _)| name);
            let given = names.find(|name| is_given(name));
            if let Some(option) = given.filter(|_| owner != self.method) {
                let expected = format!("--method {}, whose option it is", owner.name());
                return Err(self.unused(option, expected));
            }
        }
        Ok(())
    }

    /// Refuses the first shared option that was given and that the method does not use.
    pub fn refuse_replaced(&self, is_given: impl Fn(&str) -> bool) -> Result<()> {
        for (option, instead) in self.method.description().unused {
            let says_one = *option == SharedOption::SeveralLevels && self.levels == Some(1);
            if is_given(option.name()) && !says_one {
                let expected = format!("another method: this one has {instead}");
                return Err(self.unused(option.name(), expected));
            }
        }
        Ok(())
    }

    /// The names of the options whose values are not the defaults.
    pub fn changed(&self) -> Vec<&'static str> {
        let default = Self::default();
        let shared = [
            ("levels", self.levels != default.levels),
            ("metric", self.metric != default.metric),
            ("neighborhood", self.neighborhood != default.neighborhood),
            ("passes", self.passes != default.passes),
        ];
        let own = self.own_options().flat_map(|(_, own)| own.changed());
        let changed = own.chain(shared).filter(|(_, is_changed)| *is_changed);
        changed.map(|(name, _)| name).collect()
    }

    fn unused(&self, option: &str, expected: String) -> Error {
        let found = format!("given with --method {}", self.method.name());
        Error::option(option, found, expected)
    }
}
