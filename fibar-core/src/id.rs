//! Names of things by number. Mixing two of them up is a type error.

use serde::{Deserialize, Serialize};

macro_rules! number {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub u32);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

number!(
    /// A marker: one fibre end on the surface, numbered from 1.
    MarkerId
);
number!(
    /// A blinking pattern, `u_ptn` of Tone 2020: 1 is the m-sequence, 2 and up the companion codes.
    PatternId
);
number!(
    /// An LED of the base, numbered from 0.
    LedId
);

impl PatternId {
    /// The pattern that carries the phase (Tone 2020, "Blinking pattern").
    pub const M_SEQUENCE: PatternId = PatternId(1);
}
