//! Outcomes of episodes: their one table.

use crate::world::ObstacleKind;

/// The parts of an outcome beside its name; `None` for a part that it does not have.
///
/// Results store the name and these parts; [`Outcome::from_parts`] makes the outcome from them again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts<'a> {
    /// Kind of obstacle with which the robot collided.
    pub with: Option<&'a ObstacleKind>,
    /// Whether the robot stood still when it was hit.
    pub at_rest: Option<&'a bool>,
    /// Message that says what went wrong.
    pub message: Option<&'a String>,
}

/// A row of the table: documentation, variant with its parts (each a field of [`Parts`]), name in results, and whether rates
/// count it (`rated`) or leave it out (`unrated`).
macro_rules! outcomes {
    ($($(#[$doc:meta])* $Variant:ident $({ $($(#[$part_doc:meta])* $part:ident: $Part:ty),* $(,)? })? => $name:literal, $rated:ident;)*) => {
        /// How an episode ended. Failure to reach the goal is a result, never an error.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Outcome {
            $($(#[$doc])* $Variant $({ $($(#[$part_doc])* $part: $Part),* })?),*
        }

        impl Outcome {
            /// All names, in the order in which summaries count them.
            pub const NAMES: [&'static str; [$($name),*].len()] = [$($name),*];

            /// The name in results.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$Variant { .. } => $name),* }
            }

            /// Whether success rates count the episode: it had a world, and it was driven to its end.
            pub fn is_rated(&self) -> bool {
                match self { $(Self::$Variant { .. } => outcomes!(@$rated)),* }
            }

            /// The parts beside its name.
            pub fn parts(&self) -> Parts<'_> {
                match self { $(Self::$Variant $({ $($part),* })? => Parts { $($($part: Some($part),)*)? ..Parts::default() }),* }
            }

            /// The outcome of that name with those parts; `None` if the name is unknown or one of its parts is missing.
            pub fn from_parts(name: &str, parts: Parts<'_>) -> Option<Self> {
                match name {
                    $($name => Some(Self::$Variant $({ $($part: parts.$part.cloned()?),* })?),)*
                    _ => None,
                }
            }
        }
    };
    (@rated) => { true };
    (@unrated) => { false };
}

outcomes! {
    /// Within the goal tolerance, without contact, before the time-out.
    Success => "success", rated;
    /// First contact.
    Collision {
        /// With what.
        with: ObstacleKind,
        /// Whether the robot stood still when it was hit.
        at_rest: bool,
    } => "collision", rated;
    /// The time-out came first.
    Timeout => "timeout", rated;
    /// Too little progress for too long.
    Stuck => "stuck", rated;
    /// The global planner found no path at the start.
    NoPath {
        /// What the planner said.
        message: String,
    } => "no_path", rated;
    /// A planner's own fault: it said so, panicked, or gave an answer that cannot be.
    PlannerError {
        /// Which planner, and what it said.
        message: String,
    } => "planner_error", rated;
    /// A fault of simrun itself: generation of the world, physics, metrics or the writing of the row panicked, or the process that
    /// drove the episode died. It says nothing about the stack and is left out of rates.
    InternalError {
        /// What panicked, and the command that drives exactly this episode again.
        message: String,
    } => "internal_error", unrated;
    /// The process that drove the episode was stopped after the time that the user allows; left out of rates, and driven again when
    /// the run goes on. The one outcome that depends on the machine.
    GaveUp {
        /// After how long.
        message: String,
    } => "gave_up", unrated;
    /// No feasible world was found within the bound of the generator; left out of rates.
    InfeasibleWorld {
        /// What could not be placed.
        message: String,
    } => "infeasible_world", unrated;
}

impl Outcome {
    /// What went wrong, in words; empty where the name says it all.
    pub fn message(&self) -> &str {
        self.parts().message.map_or("", String::as_str)
    }

    /// Whether the goal was reached.
    pub fn is_success(&self) -> bool {
        *self == Self::Success
    }

    /// It in words, with what the robot touched: "collision with unknown static", "no path".
    pub fn words(&self) -> String {
        let name = self.name().replace('_', " ");
        match self {
            Self::Collision { with, at_rest } => {
                let rest = if *at_rest { ", standing still" } else { "" };
                format!("{name} with {}{rest}", with.name().replace('_', " "))
            }
            _ => name,
        }
    }

    /// Whether the program or a planner failed, not the robot.
    pub fn is_crash(&self) -> bool {
        matches!(self, Self::PlannerError { .. } | Self::InternalError { .. })
    }

    /// Its place in [`Self::NAMES`].
    pub fn index(&self) -> usize {
        let index = Self::NAMES.iter().position(|name| *name == self.name());
        index.expect("every outcome is named in the same table")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Outcome; 9] {
        let message = || "said so".to_owned();
        [
            Outcome::Success,
            Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: true },
            Outcome::Timeout,
            Outcome::Stuck,
            Outcome::NoPath { message: message() },
            Outcome::PlannerError { message: message() },
            Outcome::InternalError { message: message() },
            Outcome::GaveUp { message: message() },
            Outcome::InfeasibleWorld { message: message() },
        ]
    }

    #[test]
    fn every_outcome_is_put_together_again_from_its_name_and_its_parts() {
        assert_eq!(all().each_ref().map(Outcome::name), Outcome::NAMES);
        for (index, outcome) in all().iter().enumerate() {
            assert_eq!(Outcome::from_parts(outcome.name(), outcome.parts()).as_ref(), Some(outcome));
            assert_eq!(outcome.index(), index);
        }
        assert_eq!(Outcome::from_parts("late", Parts::default()), None);
        assert_eq!(Outcome::from_parts("collision", Parts::default()), None, "with nothing");
    }

    #[test]
    fn what_says_nothing_about_the_stack_is_left_out_of_rates() {
        let unrated: Vec<&str> = Outcome::NAMES[6..].to_vec();
        assert_eq!(unrated, ["internal_error", "gave_up", "infeasible_world"]);
        assert!(all().iter().all(|outcome| outcome.is_rated() != unrated.contains(&outcome.name())));
        assert_eq!(all().iter().filter(|outcome| outcome.is_success()).count(), 1);
        assert_eq!((all()[4].message(), all()[1].message()), ("said so", ""));
    }
}
