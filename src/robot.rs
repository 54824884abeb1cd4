//! The robot: footprint, limits, differential drive.

use crate::geometry::convex::{CORNERS_MAX, Polygon};
use crate::geometry::outline::Body;
use crate::geometry::{Pose, Twist, Vec2, direction};
use crate::math;
use crate::settings::quantity::{Finite, NonNegative, Positive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// A convex outline as scenarios write it: a list of corners `[x, y]`, m, in order either way round, in the frame of the
/// body that it belongs to (x forward), whose origin lies inside.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineCorners(Polygon);

impl OutlineCorners {
    /// The polygon.
    pub fn polygon(&self) -> &Polygon {
        &self.0
    }
}

impl From<Polygon> for OutlineCorners {
    fn from(polygon: Polygon) -> Self {
        Self(polygon)
    }
}

impl Serialize for OutlineCorners {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.corners().iter().map(|corner| [corner.x, corner.y]))
    }
}

impl<'de> Deserialize<'de> for OutlineCorners {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = OutlineCorners;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of corners [x, y]")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<OutlineCorners, A::Error> {
                let mut corners = Vec::new();
                while let Some([x, y]) = list.next_element::<[Finite; 2]>()? {
                    corners.push(Vec2::new(x.get(), y.get()));
                }
                Polygon::new(&corners).map(OutlineCorners).map_err(de::Error::custom)
            }
        }
        deserializer.deserialize_seq(Reader)
    }
}

impl JsonSchema for OutlineCorners {
    fn schema_name() -> Cow<'static, str> {
        "OutlineCorners".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "array", "minItems": 3, "maxItems": CORNERS_MAX,
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "examples": [[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]],
        })
    }
}

/// Shape and drive of the robot (scenario key `robot`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RobotSpec {
    /// Radius of the disc footprint, m.
    pub radius_m: Positive,
    /// A convex footprint in place of the disc: corners [x, y], m, x forward, the centre of rotation at [0, 0]. Default: none.
    pub footprint: Option<OutlineCorners>,
    /// Distance between the two driven wheels, m.
    pub track_width_m: Positive,
    /// Highest rim speed of a wheel, m/s; without it the wheels never bind before `limits`.
    pub wheel_speed_max_mps: Option<Positive>,
}

impl Default for RobotSpec {
    fn default() -> Self {
        Self {
            radius_m: Positive::new(0.25),
            footprint: None,
            track_width_m: Positive::new(0.4),
            wheel_speed_max_mps: None,
        }
    }
}

/// What the drive may do (scenario key `limits`); planners know these numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Highest forward speed, m/s.
    pub speed_max_mps: Positive,
    /// Highest reverse speed, m/s; 0 forbids reversing.
    pub reverse_speed_max_mps: NonNegative,
    /// Highest acceleration, m/s².
    pub acceleration_max_mps2: Positive,
    /// Highest deceleration, m/s²; the acceleration where absent.
    pub deceleration_max_mps2: Option<Positive>,
    /// Highest yaw rate either way, rad/s.
    pub yaw_rate_max_radps: Positive,
    /// Highest yaw acceleration either way, rad/s².
    pub yaw_acceleration_max_radps2: Positive,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            speed_max_mps: Positive::new(1.0),
            reverse_speed_max_mps: NonNegative::new(0.0),
            acceleration_max_mps2: Positive::new(0.5),
            deceleration_max_mps2: None,
            yaw_rate_max_radps: Positive::new(1.0),
            yaw_acceleration_max_radps2: Positive::new(2.0),
        }
    }
}

/// A differential-drive robot: what the world moves and what planners may count on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Radius of the disc footprint, m; for a polygon, of the smallest disc about the centre that holds it.
    pub radius_m: f64,
    /// The footprint if it is a polygon, in the robot's own frame.
    pub footprint: Option<Polygon>,
    /// Distance between the wheels, m.
    pub track_width_m: f64,
    /// Highest rim speed of a wheel, m/s (infinite if the scenario gives none).
    pub wheel_speed_max_mps: f64,
    /// Highest reverse speed, m/s; 0 if it cannot reverse.
    pub reverse_speed_max_mps: f64,
    /// Highest speed, m/s.
    pub speed_max_mps: f64,
    /// Highest acceleration, m/s².
    pub acceleration_max_mps2: f64,
    /// Highest deceleration, m/s².
    pub deceleration_max_mps2: f64,
    /// Highest yaw rate, rad/s.
    pub yaw_rate_max_radps: f64,
    /// Highest yaw acceleration, rad/s².
    pub yaw_acceleration_max_radps2: f64,
}

impl Robot {
    /// The robot that a scenario describes.
    pub fn new(spec: &RobotSpec, limits: &Limits) -> Self {
        let acceleration = limits.acceleration_max_mps2.get();
        let footprint = spec.footprint.as_ref().map(|corners| corners.polygon().clone());
        Self {
            radius_m: footprint.as_ref().map_or(spec.radius_m.get(), Polygon::circumradius_m),
            footprint,
            track_width_m: spec.track_width_m.get(),
            wheel_speed_max_mps: spec.wheel_speed_max_mps.map_or(f64::INFINITY, Positive::get),
            reverse_speed_max_mps: limits.reverse_speed_max_mps.get(),
            speed_max_mps: limits.speed_max_mps.get(),
            acceleration_max_mps2: acceleration,
            deceleration_max_mps2: limits.deceleration_max_mps2.map_or(acceleration, Positive::get),
            yaw_rate_max_radps: limits.yaw_rate_max_radps.get(),
            yaw_acceleration_max_radps2: limits.yaw_acceleration_max_radps2.get(),
        }
    }

    /// Lowest speed, m/s: minus the highest reverse speed.
    pub fn speed_min_mps(&self) -> f64 {
        0.0 - self.reverse_speed_max_mps
    }

    /// Radius of the largest disc about the centre that the footprint holds, m.
    pub fn inscribed_radius_m(&self) -> f64 {
        self.footprint.as_ref().map_or(self.radius_m, Polygon::inradius_m)
    }

    /// The footprint of the robot at `pose`.
    pub fn body(&self, pose: Pose) -> Body {
        let corners = self.footprint.as_ref().map(|polygon| polygon.placed(pose.position, direction(pose.theta)));
        Body { position: pose.position, radius_m: self.radius_m, corners }
    }

    /// The twist that the drive reaches within `dt_s` when asked for `command` while at `twist`.
    ///
    /// Speed and yaw rate are limited, then their change (speeding up by the acceleration, slowing
    /// down by the deceleration; through zero, by the deceleration), then both are scaled
    /// down together where a wheel would turn too fast, which keeps the curvature.
    pub fn actuate(&self, twist: Twist, command: Twist, dt_s: f64) -> Twist {
        let wanted_v = math::clamp(command.v, self.speed_min_mps(), self.speed_max_mps);
        let (up, down) = if twist.v >= 0.0 {
            (self.acceleration_max_mps2, self.deceleration_max_mps2)
        } else {
            (self.deceleration_max_mps2, self.acceleration_max_mps2)
        };
        let v = math::clamp(wanted_v, twist.v - down * dt_s, twist.v + up * dt_s);
        let wanted_omega = math::clamp(command.omega, -self.yaw_rate_max_radps, self.yaw_rate_max_radps);
        let step = self.yaw_acceleration_max_radps2 * dt_s;
        let omega = math::clamp(wanted_omega, twist.omega - step, twist.omega + step);
        self.within_wheel_limits(Twist { v, omega })
    }

    /// Rim speeds of the left and right wheel, m/s.
    pub fn wheel_speeds(&self, twist: Twist) -> (f64, f64) {
        let half = 0.5 * self.track_width_m * twist.omega;
        (twist.v - half, twist.v + half)
    }

    /// `twist`, scaled down so that no wheel turns faster than it can.
    pub fn within_wheel_limits(&self, twist: Twist) -> Twist {
        let fastest = twist.v.abs() + 0.5 * self.track_width_m * twist.omega.abs();
        if fastest <= self.wheel_speed_max_mps {
            return twist;
        }
        let scale = self.wheel_speed_max_mps / fastest;
        Twist { v: twist.v * scale, omega: twist.omega * scale }
    }
}

impl Default for Robot {
    fn default() -> Self {
        Self::new(&RobotSpec::default(), &Limits::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braking_takes_the_closed_form_distance() {
        // From 1 m/s at 0.5 m/s²: 2 s. Each tick drives at its end speed, so the stop takes
        // Σ (1 − 0.05 k)·0.1 for k = 1..20 = 0.95 m; the continuous v²/2a is 1 m.
        let robot = Robot::default();
        let (mut twist, mut distance, mut ticks) = (Twist { v: 1.0, omega: 0.0 }, 0.0, 0);
        while twist.v > 1e-12 {
            twist = robot.actuate(twist, Twist::ZERO, 0.1);
            distance += twist.v * 0.1;
            ticks += 1;
        }
        assert_eq!(ticks, 20);
        assert!((distance - 0.95).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn wheels_limit_the_twist_and_keep_the_curvature() {
        let robot = Robot { wheel_speed_max_mps: 0.6, ..Robot::default() };
        let twist = robot.within_wheel_limits(Twist { v: 1.0, omega: 1.0 });
        let (left, right) = robot.wheel_speeds(twist);
        assert!((right - 0.6).abs() < 1e-12 && left < right);
        assert!((twist.omega / twist.v - 1.0).abs() < 1e-12);
    }
}
