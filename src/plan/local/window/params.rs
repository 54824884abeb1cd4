//! The parameters that every planner over the dynamic window shares.

/// Makes the parameters of a planner that weighs the window's rollouts: its own ones, then those of the window and
/// of what [`Terms`] measures, which mean the same for all and have the same defaults.
macro_rules! window_params {
    ($(#[$about:meta])* pub struct Params { $($(#[$doc:meta])* pub $field:ident: $type:ty = $default:expr,)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Params {
            $($(#[$doc])* pub $field: $type,)*
            /// Whether movers are predicted at constant velocity; else they stand where they are. Default true.
            pub predict_dynamic: bool,
            /// Weight π of the progress along the path; only with `normalise: fixed`. Default 1.
            pub progress_weight: $crate::settings::quantity::NonNegative,
            /// Weight δ of the distance from the path; higher holds the robot to it. Only with `normalise: fixed`, and in `follow_dwa`.
            /// Default 0.5.
            pub path_weight: $crate::settings::quantity::NonNegative,
            /// The scales of the objective. Default `fixed`.
            pub normalise: $crate::plan::local::window::Normalise,
            /// Time predicted against statics, s, rounded to whole control periods. Longer sees farther and admits less.
            /// Default: what stopping from top speed takes within the arc that was looked at, v / 2a, and 0.5 s; at least 1.5 s.
            pub horizon_s: Option<$crate::settings::quantity::Positive>,
            /// Time predicted against movers with `normalise: fixed`, s; with `sum` it is `horizon_s`. Default: what stopping
            /// from top speed takes, v / a, and 1 s; at least 3 s.
            pub movers_horizon_s: Option<$crate::settings::quantity::Positive>,
            /// Distance that an admissible rollout keeps from statics, m, or as much of it as there is. Default 0.02.
            pub room_m: $crate::settings::quantity::NonNegative,
            /// Step between sampled speeds, m/s; without it `speed_samples` counts. The papers' scenarios use 0.01 to 0.02.
            pub speed_step_mps: Option<$crate::settings::quantity::Positive>,
            /// Step between sampled yaw rates, rad/s; without it `yaw_rate_samples` counts.
            pub yaw_rate_step_radps: Option<$crate::settings::quantity::Positive>,
            /// Sampled speeds, evenly over the window. A count fits the window of any robot and bounds the cost of a
            /// decision; more than a few change little. Default 11 (every 0.01 m/s at 0.5 m/s²).
            pub speed_samples: $crate::settings::quantity::Samples,
            /// Sampled yaw rates, evenly over the window. Default 21 (every 0.02 rad/s at 2 rad/s²).
            pub yaw_rate_samples: $crate::settings::quantity::Samples,
            /// How a rollout moves. Default `arc`.
            pub prediction: $crate::plan::local::window::Prediction,
            /// Where the clearance of a rollout is taken with `normalise: sum`; with `fixed` over the whole. Default `path_min`.
            pub dist_mode: $crate::plan::local::window::DistanceMode,
            /// How clearances are measured with `normalise: sum` and a disc-shaped robot; else they are bounds. Default `exact`.
            pub clearances: $crate::plan::local::window::Measure,
            /// Clearance above which a rollout is no better, m. Default 0.3.
            pub d_cap_m: $crate::settings::quantity::Positive,
            /// What heading and pull aim at with `normalise: sum`. Default `sub_goal`.
            pub target: $crate::plan::local::window::Target,
            /// Where the heading of a rollout is judged with `normalise: sum`; with `fixed` on arrival. Default `arrival`.
            pub heading_at: $crate::plan::local::window::HeadingAt,
            /// The distance in which the robot must be able to stop. Default `arc`.
            pub va_distance: $crate::plan::local::window::BrakingDistance,
            /// How that rule bounds the yaw rate. Default `printed`.
            pub va_angular: $crate::plan::local::window::BrakingTurn,
            /// Whether that distance is cut as well, which caps the speed at √(2 a d), as in the demo the papers' numbers
            /// come from. Default false.
            pub va_uses_clip: bool,
            /// Where it is cut, m; `d_cap_m` where absent.
            pub va_clip_m: Option<$crate::settings::quantity::Positive>,
        }

        impl Default for Params {
            fn default() -> Self {
                use $crate::plan::local::window;
                use $crate::settings::quantity::{NonNegative, Positive, Samples};
                Self {
                    $($field: $default,)*
                    predict_dynamic: true,
                    progress_weight: NonNegative::new(1.0),
                    path_weight: NonNegative::new(0.5),
                    normalise: window::Normalise::Fixed,
                    horizon_s: None,
                    movers_horizon_s: None,
                    room_m: NonNegative::new(0.02),
                    speed_step_mps: None,
                    yaw_rate_step_radps: None,
                    speed_samples: Samples::new(11),
                    yaw_rate_samples: Samples::new(21),
                    prediction: window::Prediction::Arc,
                    dist_mode: window::DistanceMode::PathMin,
                    clearances: window::Measure::Exact,
                    d_cap_m: Positive::new(0.3),
                    target: window::Target::SubGoal,
                    heading_at: window::HeadingAt::Arrival,
                    va_distance: window::BrakingDistance::Arc,
                    va_angular: window::BrakingTurn::Printed,
                    va_uses_clip: false,
                    va_clip_m: None,
                }
            }
        }

        impl Params {
            /// The settings of the window that these parameters describe.
            fn window(&self) -> $crate::plan::local::window::Settings {
                use $crate::plan::local::window::{Settings, Spacing};
                use $crate::settings::quantity::{Positive, Samples};
                let spacing = |step: Option<Positive>, samples: Samples| {
                    step.map_or(Spacing::Count(samples.get()), |step| Spacing::Step(step.get()))
                };
                Settings {
                    normalise: self.normalise,
                    horizon_s: self.horizon_s.map(Positive::get),
                    movers_horizon_s: self.movers_horizon_s.map(Positive::get),
                    room_m: self.room_m.get(),
                    prediction: self.prediction,
                    speed: spacing(self.speed_step_mps, self.speed_samples),
                    yaw_rate: spacing(self.yaw_rate_step_radps, self.yaw_rate_samples),
                    predict_dynamic: self.predict_dynamic,
                    clearance_cap_m: self.d_cap_m.get(),
                    distance_mode: self.dist_mode,
                    measure: self.clearances,
                    braking_distance: self.va_distance,
                    braking_clip_m: self.va_uses_clip.then(|| self.va_clip_m.unwrap_or(self.d_cap_m).get()),
                    braking_turn: self.va_angular,
                }
            }

            /// The weights of the objective on fixed scales.
            fn weights(&self, velocity: f64) -> $crate::plan::local::window::objective::Weights {
                $crate::plan::local::window::objective::Weights {
                    progress: self.progress_weight.get(),
                    path: self.path_weight.get(),
                    heading: self.heading_weight.get(),
                    distance: self.distance_weight.get(),
                    movers: self.distance_weight.get(),
                    velocity,
                }
            }

            /// The terms of the objective, by these parameters, for the rollouts of one cycle.
            fn terms<'a>(
                &self,
                rollouts: &'a $crate::plan::local::window::Rollouts,
                situation: &'a $crate::plan::contract::Situation<'a>,
                target: $crate::geometry::Vec2,
            ) -> $crate::plan::local::window::Terms<'a> {
                $crate::plan::local::window::Terms {
                    rollouts,
                    situation,
                    target,
                    heading_at: self.heading_at,
                    dist_mode: self.dist_mode,
                    d_cap_m: self.d_cap_m.get(),
                }
            }
        }
    };
}
pub(crate) use window_params;
