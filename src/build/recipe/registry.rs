//! The table of build methods and that of presets: one row each, which feeds help, META and the build key. Which options a method reads
//! stands in the table of options.

use super::options::{BuildOptions, Method, Preset};

/// What there is to say about a method.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MethodInfo {
    /// The method that the row is about.
    pub method: Method,
    /// What users type and files name.
    pub name: &'static str,
    /// Raised when the same input and options give another tree, and only then: old caches are out of date from there
    /// on. [`Method::revision`] is what files name.
    pub revision: u32,
    /// One line of help.
    pub summary: &'static str,
}

/// Every method, in the order in which they are listed.
pub const METHODS: &[MethodInfo] = &[
    MethodInfo {
        method: Method::Binned,
        name: "binned",
        revision: 1,
        summary: "object splits only, chosen among equal bins on three axes; quickest",
    },
    MethodInfo {
        method: Method::Sbvh,
        name: "sbvh",
        revision: 3,
        summary: "object and spatial splits compete; best where triangles are large or thin",
    },
    MethodInfo {
        method: Method::Bonsai,
        name: "bonsai",
        revision: 2,
        summary: "object splits only: sweep trees of small groups, pruned, under one over them; quicker than sweep, better on architecture",
    },
    MethodInfo {
        method: Method::Sweep,
        name: "sweep",
        revision: 1,
        summary: "object splits only, chosen among all planes on three axes; the measure of the others",
    },
    MethodInfo {
        method: Method::Agglomerative,
        name: "agglomerative",
        revision: 2,
        summary: "from the triangles up: neighbours on a Morton curve merge with their best match",
    },
    MethodInfo {
        method: Method::Oabb,
        name: "oabb",
        revision: 1,
        summary: "the same by boxes that lie along what they hold: those that propose to each other merge",
    },
    MethodInfo {
        method: Method::Auto,
        name: "auto",
        revision: 4,
        summary: "a search: sweep, then spatial splits, then reinsertion and adaptation, as far as measured rays say that they pay",
    },
    MethodInfo {
        method: Method::Best,
        name: "best",
        revision: 4,
        summary: "a search: several recipes, of which measured rays decide",
    },
];

/// What a preset starts from. The values of its options stand in the table of options.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PresetInfo {
    /// The preset that the row is about.
    pub preset: Preset,
    /// What users type.
    pub name: &'static str,
    /// The method that it builds by, unless another is named.
    pub method: Method,
}

/// Every preset, in the order in which they are listed.
pub(crate) const PRESETS: &[PresetInfo] = &[
    PresetInfo { preset: Preset::Auto, name: "auto", method: Method::Auto },
    PresetInfo { preset: Preset::Draft, name: "draft", method: Method::Binned },
    PresetInfo { preset: Preset::Balanced, name: "balanced", method: Method::Sbvh },
    PresetInfo { preset: Preset::Best, name: "best", method: Method::Best },
];

impl Preset {
    /// The preset's row.
    pub(crate) fn info(self) -> &'static PresetInfo {
        // A new preset does not compile without a row here; a test proves that it is its own.
        &PRESETS[match self {
            Preset::Auto => 0,
            Preset::Draft => 1,
            Preset::Balanced => 2,
            Preset::Best => 3,
        }]
    }
}

/// Raised when adaptation makes another tree of the same one: it is a pass, which trees of any method go through.
const ADAPT_REVISION: u32 = 1;

impl BuildOptions {
    /// The revision of what these options build: the method's, and that of adaptation where it is done. Their sum grows when either does.
    pub fn revision(&self) -> u32 {
        let is_adapted = self.adapt > 0 && !self.method.is_search();
        self.method.revision() + if is_adapted { ADAPT_REVISION } else { 0 }
    }
}

impl Method {
    /// The method's row of [`METHODS`].
    pub fn info(self) -> &'static MethodInfo {
        // A new method does not compile without a row here; a test proves that it is its own.
        &METHODS[match self {
            Method::Binned => 0,
            Method::Sbvh => 1,
            Method::Bonsai => 2,
            Method::Sweep => 3,
            Method::Agglomerative => 4,
            Method::Oabb => 5,
            Method::Auto => 6,
            Method::Best => 7,
        }]
    }

    /// Whether it tries other methods and takes one's tree.
    pub fn is_search(self) -> bool {
        matches!(self, Method::Auto | Method::Best)
    }

    /// The revision of the method's output. A search's stands for its rule and for every method that it might take, adapted: their sum grows
    /// when any of them does. No search takes [`Method::Oabb`].
    pub fn revision(self) -> u32 {
        if self.is_search() {
            let others: u32 = METHODS
                .iter()
                .filter(|row| !row.method.is_search() && row.method != Method::Oabb)
                .map(|row| row.revision)
                .sum();
            self.info().revision + others + ADAPT_REVISION
        } else {
            self.info().revision
        }
    }
}
