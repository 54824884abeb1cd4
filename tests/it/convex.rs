//! Convex polygons against sampled outlines, parry and closed forms.

use rapier2d::parry::query;
use rapier2d::parry::shape::ConvexPolygon;
use rapier2d::prelude::{Pose as RapierPose, Vector};
use simrun::geometry::convex::*;
use simrun::geometry::outline::Hit;
use simrun::geometry::{Rect, Vec2, direction};
use simrun::math;
use simrun::rng::{EpisodeSeed, Purpose, Stream};

fn stream(seed: u64) -> Stream {
    EpisodeSeed { seed, episode: 0 }.stream(Purpose::Planner, 0)
}

/// Points on an ellipse are convex.
fn random_polygon(stream: &mut Stream) -> Polygon {
    loop {
        let count = 3 + stream.index(6);
        let (a, b) = (stream.range(0.2, 1.0), stream.range(0.2, 1.0));
        let mut angles: Vec<f64> = (0..count).map(|_| stream.range(-math::PI, math::PI)).collect();
        angles.sort_by(f64::total_cmp);
        let corners: Vec<Vec2> =
            angles.iter().map(|&angle| Vec2::new(a * math::cos(angle), b * math::sin(angle))).collect();
        if let Ok(polygon) = Polygon::new(&corners)
            && polygon.inradius_m() > 0.02
        {
            return polygon;
        }
    }
}

fn placed(stream: &mut Stream, polygon: &Polygon, range_m: f64) -> Corners {
    let position = Vec2::new(stream.range(-range_m, range_m), stream.range(-range_m, range_m));
    polygon.placed(position, direction(stream.range(-math::PI, math::PI)))
}

fn parry(corners: &[Vec2]) -> ConvexPolygon {
    let points = corners.iter().map(|p| Vector::new(p.x as f32, p.y as f32)).collect();
    ConvexPolygon::from_convex_polyline_unmodified(points).expect("convex")
}

fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The sides of an outline.
fn edges(corners: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
    (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]))
}

const SPACING_M: f64 = 0.01;

/// Points of an outline, no two neighbours farther apart than twice the spacing.
fn outline(corners: &[Vec2]) -> impl Iterator<Item = Vec2> + '_ {
    edges(corners).flat_map(|(a, b)| {
        let count = 1.0 + ((b - a).norm() / (2.0 * SPACING_M)).floor();
        (0..count as u32).map(move |k| a + (b - a) * (f64::from(k) / count))
    })
}

#[test]
fn distances_equal_those_of_sampled_outlines_and_depths_part_the_two() {
    let mut stream = stream(1);
    let (mut apart, mut overlapping) = (0, 0);
    for _ in 0..20_000 {
        let (p, q) = (random_polygon(&mut stream), random_polygon(&mut stream));
        let (a, b) = (placed(&mut stream, &p, 1.2), placed(&mut stream, &q, 1.2));
        let ours = distance(&a, &b);
        assert!((ours - distance(&b, &a)).abs() < 1e-12);
        let sampled = outline(&a).map(|p| point_distance(&b, p)).fold(f64::INFINITY, math::min);
        if ours > 0.0 {
            apart += 1;
            assert!(ours <= sampled + 1e-12 && sampled <= ours + SPACING_M, "{ours} {sampled}");
            // Which iterates in single precision.
            let still = RapierPose::IDENTITY;
            let parry = query::distance(&still, &parry(&a), &still, &parry(&b)).expect("supported").distance;
            assert!((ours - f64::from(parry)).abs() < 5e-3, "{ours} {parry}");
        } else {
            overlapping += 1;
            // Their outlines cross, or one lies within the other.
            assert!(sampled < SPACING_M || outline(&b).all(|p| point_distance(&a, p) < 0.0), "{ours} {sampled}");
            // No shorter translation parts them, and one of that length does.
            let parts = |length: f64| {
                (0..3600).any(|k| {
                    let shift = length * direction(math::TAU * f64::from(k) / 3600.0);
                    distance(&a.map(|p| p + shift), &b) >= 0.0
                })
            };
            if overlapping < 40 {
                assert!(parts(-1.001 * ours + 1e-6) && !parts(-0.99 * ours - 1e-6), "{ours}");
            }
        }
    }
    assert!(apart > 2000 && overlapping > 2000, "{apart} {overlapping}");
}

#[test]
fn distances_of_points_equal_those_of_sampled_outlines_and_rays_end_on_them() {
    let (mut stream, mut hits) = (stream(2), 0);
    for _ in 0..20_000 {
        let polygon = random_polygon(&mut stream);
        let corners = placed(&mut stream, &polygon, 0.5);
        let p = Vec2::new(stream.range(-2.0, 2.0), stream.range(-2.0, 2.0));
        let ours = point_distance(&corners, p);
        let sampled = outline(&corners).map(|q| (p - q).norm()).fold(f64::INFINITY, math::min);
        assert!(ours.abs() <= sampled + 1e-12 && sampled <= ours.abs() + SPACING_M, "{ours} {sampled}");
        // Inside where the outline winds round the point once.
        let turns: f64 = edges(&corners).map(|(a, b)| math::atan2(cross(a - p, b - p), (a - p).dot(&(b - p)))).sum();
        assert_eq!(ours < 0.0, turns > math::PI, "{ours} {turns}");
        let near = nearest_point(&corners, p);
        assert!(((p - near).norm() - math::max(ours, 0.0)).abs() < 1e-9);
        let unit = direction(stream.range(-math::PI, math::PI));
        let hit = cast_ray(&corners, p, unit);
        let clear =
            |until: f64| (0..200).all(|k| point_distance(&corners, p + unit * until * f64::from(k) / 200.0) > 0.0);
        if ours <= 0.0 {
            assert_eq!(hit, 0.0);
        } else if hit.is_finite() {
            hits += 1;
            assert!(clear(hit) && point_distance(&corners, p + unit * hit).abs() < 1e-9);
        } else {
            assert!(clear(8.0));
        }
    }
    assert!(hits > 2000, "{hits}");
}

#[test]
fn first_contacts_leave_no_gap_and_no_overlap() {
    let (mut stream, mut hits) = (stream(3), 0);
    for case in 0..4000 {
        let (p, q) = (random_polygon(&mut stream), random_polygon(&mut stream));
        let (still, moving) = (placed(&mut stream, &p, 1.5), placed(&mut stream, &q, 1.5));
        let velocity = stream.range(0.1, 5.0) * direction(stream.range(-math::PI, math::PI));
        let (centre, radius) = (moving[0], stream.range(0.05, 0.5));
        let is_disc = case % 2 == 0;
        let gap = |t: f64| {
            if is_disc {
                point_distance(&still, centre + velocity * t) - radius
            } else {
                distance(&still, &moving.map(|p| p + velocity * t))
            }
        };
        if gap(0.0) < 0.0 {
            continue;
        }
        let hit = if is_disc { sweep_disc(centre, velocity, radius, &still) } else { sweep(&moving, velocity, &still) };
        let until = hit.map_or(3.0, |hit| hit.time_s);
        for k in 0..100 {
            let t = until * f64::from(k) / 100.0;
            assert!(gap(t) > -1e-9, "overlap of {} before the contact", -gap(t));
        }
        if let Some(Hit { time_s: time, normal }) = hit {
            hits += 1;
            assert!(gap(time).abs() < 1e-9, "{}", gap(time));
            assert!(velocity.dot(&normal) < 0.0 && (normal.norm() - 1.0).abs() < 1e-12);
            // A step back along the normal parts them by its length.
            let back = if is_disc {
                point_distance(&still, centre + velocity * time + 1e-4 * normal) - radius
            } else {
                distance(&still, &moving.map(|p| p + velocity * time + 1e-4 * normal))
            };
            assert!((back - 1e-4).abs() < 1e-7, "{back}");
        }
    }
    assert!(hits > 400, "{hits}");
}

#[test]
fn overlapping_bodies_touch_at_once_unless_they_part() {
    let square = |x: f64| rectangle(Rect { min: Vec2::new(x, 0.0), max: Vec2::new(x + 1.0, 1.0) });
    let (still, moving) = (square(0.0), square(0.9));
    let out = Vec2::new(1.0, 0.0);
    let at_once = Some(Hit { time_s: 0.0, normal: out });
    assert_eq!(sweep(&moving, -out, &still), at_once);
    assert_eq!(sweep(&moving, out, &still), None);
    assert_eq!(sweep_disc(Vec2::new(1.2, 0.5), -out, 0.3, &still), at_once);
    assert_eq!(sweep_disc(Vec2::new(1.2, 0.5), out, 0.3, &still), None);
}

#[test]
fn discs_cover_the_polygon_and_hardly_more() {
    let mut stream = stream(4);
    let half = |x: f64, y: f64| rectangle(Rect { min: Vec2::new(-x, -y), max: Vec2::new(x, y) }).to_vec();
    let mut polygons = vec![half(0.254, 0.215), half(0.6, 0.3), half(0.2, 0.2), half(1.0, 0.1)];
    polygons.extend((0..40).map(|_| random_polygon(&mut stream).corners().to_vec()));
    for corners in polygons {
        let polygon = Polygon::new(&corners).unwrap();
        let cover = polygon.cover();
        for _ in 0..4000 {
            let box_ = bounds(&corners);
            let p = Vec2::new(stream.range(box_.min.x, box_.max.x), stream.range(box_.min.y, box_.max.y));
            let p = nearest_point(polygon.corners(), p);
            let from_cover = cover.iter().map(|d| (p - d.centre).norm() - d.radius_m).fold(f64::INFINITY, math::min);
            assert!(from_cover <= 1e-12, "{p:?} of {corners:?} is {from_cover} outside");
        }
        for disc in cover {
            let overhang = disc.radius_m + point_distance(polygon.corners(), disc.centre);
            assert!(cover.len() == 1 || overhang <= 0.5 * polygon.inradius_m() + 1e-12);
        }
        assert!(cover.len() <= 32);
    }
    // A Jackal's outline: within 5 cm of it everywhere.
    let jackal = Polygon::new(&half(0.254, 0.215)).unwrap();
    let overhang = |d: &Disc| d.radius_m + point_distance(jackal.corners(), d.centre);
    assert!(jackal.cover().iter().all(|disc| overhang(disc) < 0.05), "{:?}", jackal.cover());
}

#[test]
fn outlines_that_are_not_convex_about_the_origin_are_refused() {
    let polygon =
        |corners: &[(f64, f64)]| Polygon::new(&corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect::<Vec<_>>());
    assert!(polygon(&[(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]).is_ok());
    let clockwise = polygon(&[(-1.0, -1.0), (0.0, 1.0), (1.0, -1.0)]).unwrap();
    assert!(
        cross(clockwise.corners()[1] - clockwise.corners()[0], clockwise.corners()[2] - clockwise.corners()[1]) > 0.0
    );
    for (corners, says) in [
        (&[(-1.0, -1.0), (1.0, -1.0)][..], "3 to 16 corners, not 2"),
        (&[(-1.0, -1.0), (1.0, -1.0), (-0.2, -0.2), (-1.0, 1.0)], "not bend outwards at [-0.2, -0.2]"),
        (&[(-1.0, -1.0), (0.0, -1.0), (1.0, -1.0), (0.0, 1.0)], "not bend outwards at [0, -1]"),
        (&[(1.0, 1.0), (2.0, 1.0), (2.0, 2.0)], "[0, 0]"),
    ] {
        let message = polygon(corners).unwrap_err();
        assert!(message.contains(says), "{message}");
    }
    // A pentagram turns left at every corner, twice round.
    let star: Vec<Vec2> = (0..5).map(|k| direction(math::TAU * f64::from(2 * k) / 5.0)).collect();
    assert!(Polygon::new(&star).unwrap_err().contains("more than once"));
}

#[test]
fn a_disc_meets_a_wall_after_its_closed_form() {
    // 2 m away at 1 m/s, radius 0.5: after 1.5 s.
    let wall = rectangle(Rect { min: Vec2::new(0.0, -1.0), max: Vec2::new(1.0, 1.0) });
    let hit = sweep_disc(Vec2::new(3.0, 0.0), Vec2::new(-1.0, 0.0), 0.5, &wall).unwrap();
    assert!((hit.time_s - 1.5).abs() < 1e-12 && hit.normal == Vec2::new(1.0, 0.0));
}
