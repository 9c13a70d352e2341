//! How well contacts with friction hold an object: the largest wrench that they balance in every direction (Ferrari & Canny 1992).
//!
//! In the plane a wrench is a force and a moment over the object's radius. A contact gives those of its friction cone, spanned by two
//! edges; with normal forces that add up to at most 1 ("L1") contacts together give the convex hull of all edges and 0, with each of at
//! most 1 ("L∞") the sum of their triangles. Q1 is the radius of the largest ball about 0 in it: 0 where some wrench cannot be balanced.
//!
//! A ball fits as far as the support function h(u) of the set reaches in its least direction; that is normal to a face of the set, and
//! the normals of all faces are among the cross products of its edges. So all of these are looked at.

/// A contact with the object: where, which way its normal force pushes the object (of length 1), and its friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Holding {
    pub point_m: [f64; 2],
    pub push: [f64; 2],
    pub mu: f64,
}

/// What contacts hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceClosure {
    /// Whether any wrench can be balanced.
    pub closed: bool,
    /// Q1 where normal forces add up to 1, and where each is at most 1.
    pub q1_l1: f64,
    pub q1_linf: f64,
    /// The certificate, a wrench (force, moment over radius) of length 1: the direction in which least can be given. Where the contacts do
    /// not close, they give nothing at all along it.
    pub weakest: [f64; 3],
}

type Wrench = [f64; 3];

/// Below this Q1 is rounding.
const NOTHING: f64 = 1e-12;

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &Wrench, b: &Wrench) -> Wrench {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: &Wrench, b: &Wrench) -> Wrench {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Edges of a contact's friction cone, of normal force 1.
fn edges(contact: &Holding, centre_m: [f64; 2], radius_m: f64) -> [Wrench; 2] {
    let [nx, ny] = contact.push;
    let lever = [contact.point_m[0] - centre_m[0], contact.point_m[1] - centre_m[1]];
    [contact.mu, -contact.mu].map(|mu| {
        let force = [nx - mu * ny, ny + mu * nx];
        [force[0], force[1], (lever[0] * force[1] - lever[1] * force[0]) / radius_m]
    })
}

/// How contacts hold an object about its centre.
pub fn force_closure(contacts: &[Holding], centre_m: [f64; 2], radius_m: f64) -> ForceClosure {
    let cones: Vec<[Wrench; 2]> = contacts.iter().map(|contact| edges(contact, centre_m, radius_m)).collect();
    let points: Vec<Wrench> = cones.iter().flatten().copied().collect();
    let most = |u: &Wrench, of: &[Wrench]| of.iter().map(|point| dot(u, point)).fold(0.0, f64::max);
    let of_one = |u: &Wrench| most(u, &points);
    let of_each = |u: &Wrench| cones.iter().map(|cone| most(u, cone)).sum::<f64>();

    // Directions of edges of both sets: from 0 to every point, and between points.
    let mut along: Vec<Wrench> = points.clone();
    for (i, a) in points.iter().enumerate() {
        along.extend(points[i + 1..].iter().map(|b| minus(a, b)));
    }
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    along.extend(axes);
    let mut found = ForceClosure { closed: false, q1_l1: f64::INFINITY, q1_linf: f64::INFINITY, weakest: axes[0] };
    let mut look = |u: Wrench| {
        let (one, each) = (of_one(&u), of_each(&u));
        found.q1_linf = found.q1_linf.min(each);
        if one < found.q1_l1 {
            (found.q1_l1, found.weakest) = (one, u);
        }
    };
    for (i, a) in along.iter().enumerate() {
        for b in &along[i + 1..] {
            let normal = cross(a, b);
            let length = dot(&normal, &normal).sqrt();
            if length > NOTHING {
                let u = normal.map(|part| part / length);
                look(u);
                look(u.map(|part| -part));
            }
        }
    }
    found.closed = found.q1_l1 > NOTHING;
    if !found.closed {
        (found.q1_l1, found.q1_linf) = (0.0, 0.0);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.02;

    /// A contact at an angle of the disc, pushing to its centre.
    fn at(degrees: f64, mu: f64) -> Holding {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Holding { point_m: [RADIUS * cos, RADIUS * sin], push: [-cos, -sin], mu }
    }

    fn of(contacts: &[Holding]) -> ForceClosure {
        force_closure(contacts, [0.0; 2], RADIUS)
    }

    #[test]
    fn two_antipodal_contacts_have_their_closed_form() {
        for mu in [0.05, 0.3, 0.8, 2.0f64] {
            for turn in [0.0, 33.0, 90.0] {
                let found = of(&[at(turn, mu), at(turn + 180.0, mu)]);
                let expected = mu / (2.0 + mu * mu).sqrt();
                assert!(found.closed && (found.q1_l1 - expected).abs() < 1e-12, "{mu}: {found:?}");
                assert!(found.q1_linf >= found.q1_l1);
            }
        }
    }

    #[test]
    fn what_is_not_closed_has_a_certificate() {
        // Without friction nothing turns a disc; with friction on one side alone it can be lifted off.
        for contacts in [
            vec![at(0.0, 0.0), at(120.0, 0.0), at(240.0, 0.0)],
            vec![at(0.0, 0.5)],
            vec![at(10.0, 0.1), at(-10.0, 0.1)],
            vec![],
        ] {
            let found = of(&contacts);
            assert!(!found.closed && found.q1_l1 == 0.0 && found.q1_linf == 0.0, "{found:?}");
            let given = contacts.iter().flat_map(|contact| edges(contact, [0.0; 2], RADIUS));
            let most = given.map(|wrench| dot(&found.weakest, &wrench)).fold(0.0, f64::max);
            assert!(most <= NOTHING && (dot(&found.weakest, &found.weakest) - 1.0).abs() < 1e-12);
        }
    }

    /// Three contacts at 120°: the least direction against a dense search.
    #[test]
    fn the_least_direction_is_found() {
        let contacts = [at(5.0, 0.4), at(131.0, 0.7), at(246.0, 0.2), at(300.0, 0.9)];
        let found = of(&contacts);
        let cones: Vec<[Wrench; 2]> = contacts.iter().map(|contact| edges(contact, [0.0; 2], RADIUS)).collect();
        let (mut one, mut each) = (f64::INFINITY, f64::INFINITY);
        for i in 0..400 {
            for j in 0..400 {
                let z: f64 = -1.0 + 2.0 * (f64::from(i) + 0.5) / 400.0;
                let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / 400.0).sin_cos();
                let around = (1.0 - z * z).sqrt();
                let u = [around * cos, around * sin, z];
                let most: Vec<f64> =
                    cones.iter().map(|cone| cone.iter().map(|w| dot(&u, w)).fold(0.0, f64::max)).collect();
                one = one.min(most.iter().copied().fold(0.0, f64::max));
                each = each.min(most.iter().sum());
            }
        }
        assert!(found.q1_l1 <= one && found.q1_l1 > one - 0.01, "{found:?} {one}");
        assert!(found.q1_linf <= each && found.q1_linf > each - 0.02, "{found:?} {each}");
    }
}
