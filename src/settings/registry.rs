//! The registry of one kind of thing: from a list of modules to everything that must agree with that list.

/// Declares one module for each name, the choice between them, and the table of their entries and behaviours.
///
/// `registry! { /// docs  pub enum Name: "what errors call it", Entry, dyn Behaviour { module, … } }`
///
/// Kinds of several folders are grouped: `{ /// docs of the folder  folder { module, … } … }`.
///
/// Each module is a file that holds `Params` (which implements the trait `Behaviour`) and `ENTRY` (of the type `Entry`,
/// with a `summary`).
macro_rules! registry {
    ($(#[$doc:meta])* $vis:vis enum $Name:ident: $what:literal, $Entry:ty, dyn $Behaviour:path { $($module:ident),+ $(,)? }) => {
        $(pub mod $module;)+
        $crate::settings::registry! {
            @table $(#[$doc])* $vis enum $Name: $what, $Entry, dyn $Behaviour { $($module),+ }
        }
    };
    ($(#[$doc:meta])* $vis:vis enum $Name:ident: $what:literal, $Entry:ty, dyn $Behaviour:path {
        $($(#[$folder_doc:meta])* $folder:ident { $($module:ident),+ $(,)? })+
    }) => {
        $($(#[$folder_doc])* pub mod $folder { $(pub mod $module;)+ })+
        $(use $folder::{$($module),+};)+
        $crate::settings::registry! {
            @table $(#[$doc])* $vis enum $Name: $what, $Entry, dyn $Behaviour { $($($module),+),+ }
        }
    };
    (@table $(#[$doc:meta])* $vis:vis enum $Name:ident: $what:literal, $Entry:ty, dyn $Behaviour:path { $($module:ident),+ }) => {
        $crate::settings::choice::choice! {
            $(#[$doc])*
            $vis enum $Name: $what { $($module = $module::ENTRY.summary),+ }
        }

        impl $Name {
            /// The registry entry of each kind, in the order of [`Self::NAMES`].
            pub const ENTRIES: &'static [$Entry] = &[$($module::ENTRY),+];

            /// The registry entry of this kind.
            pub fn entry(&self) -> &'static $Entry {
                match self { $(Self::$module(_) => &$module::ENTRY),+ }
            }

            /// Behaviour of the chosen kind.
            pub fn kind(&self) -> &dyn $Behaviour {
                match self { $(Self::$module(params) => params),+ }
            }

            /// Mutable access to the chosen kind, to change its parameters.
            pub fn kind_mut(&mut self) -> &mut dyn $Behaviour {
                match self { $(Self::$module(params) => params),+ }
            }
        }
    };
}
pub(crate) use registry;
