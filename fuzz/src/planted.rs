//! Faults planted on purpose, to see that a campaign finds what it is there for: each panics where a case has come as far as a certain rule
//! or message.

use crate::targets::Target;

/// What a case came upon: numbers of rules, texts of errors, marks of what was read.
pub type Seen = Vec<String>;

/// Which fault a run shall find, if any.
pub struct Plan(Option<&'static str>);

impl Plan {
    pub const NONE: Plan = Plan(None);

    /// The target's fault of this name. An unknown name ends the run, since nothing would be found then.
    pub fn of(target: &Target, name: Option<&str>) -> Plan {
        Plan(name.map(|name| {
            let known = target.faults.iter().find(|fault| **fault == name);
            *known.unwrap_or_else(|| panic!("{} has no fault {name}, but {:?}", target.name, target.faults))
        }))
    }

    /// Panic where the planted fault would.
    pub fn judge(&self, seen: &Seen) {
        if let Some(fault) = self.0 {
            assert!(!seen.iter().any(|text| text.contains(fault)), "the planted fault {fault}");
        }
    }
}
