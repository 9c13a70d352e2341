//! Force closure: the largest wrench that contacts with friction balance in every direction (Ferrari & Canny 1992).
//!
//! In the plane a wrench is a force and a moment divided by the object's radius. The wrenches of a contact form its
//! friction cone, spanned by two edges. If the normal forces sum to at most 1 ("L1"), the wrenches of all contacts form
//! the convex hull of all edges and 0; if each normal force is at most 1 ("L∞"), they form the Minkowski sum of the
//! triangles. Q1 is the radius of the largest ball about 0 in this set; it is 0 if some wrench cannot be balanced.
//!
//! Q1 is the minimum of the support function h(u) of the set over unit vectors u. The minimum is attained at the normal
//! of a face, and the normals of all faces are among the cross products of the edges. Hence all of these are evaluated.

/// A contact with the object: point, direction of the normal force on the object (a unit vector), and friction
/// coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionContact {
    pub point_m: [f64; 2],
    pub push: [f64; 2],
    pub mu: f64,
}

/// Force closure of a set of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceClosure {
    /// Whether every wrench can be balanced.
    pub closed: bool,
    /// Q1 for normal forces that sum to 1.
    pub q1_l1: f64,
    /// Q1 for normal forces of at most 1 each.
    pub q1_linf: f64,
    /// Certificate: a unit wrench (force, moment over radius) in the direction of the smallest wrench that can be
    /// balanced. Without force closure, the contacts balance no wrench in this direction.
    pub weakest: [f64; 3],
}

/// A force and a moment divided by the radius of the object.
pub type Wrench = nalgebra::Vector3<f64>;

/// Q1 below this is rounding.
const ZERO_TOLERANCE: f64 = 1e-12;

/// Edges of a contact's friction cone for a normal force of 1.
pub(super) fn edges(contact: &FrictionContact, centre_m: [f64; 2], radius_m: f64) -> [Wrench; 2] {
    let [nx, ny] = contact.push;
    let lever = [contact.point_m[0] - centre_m[0], contact.point_m[1] - centre_m[1]];
    [contact.mu, -contact.mu].map(|mu| {
        let force = [nx - mu * ny, ny + mu * nx];
        Wrench::new(force[0], force[1], (lever[0] * force[1] - lever[1] * force[0]) / radius_m)
    })
}

/// Computes the force closure of contacts with an object, with moments about its centre.
pub fn force_closure(contacts: &[FrictionContact], centre_m: [f64; 2], radius_m: f64) -> ForceClosure {
    let cones: Vec<[Wrench; 2]> = contacts.iter().map(|contact| edges(contact, centre_m, radius_m)).collect();
    let points: Vec<Wrench> = cones.iter().flatten().copied().collect();
    let support = |u: &Wrench, edges: &[Wrench]| edges.iter().map(|point| u.dot(point)).fold(0.0, f64::max);
    let l1_support = |u: &Wrench| support(u, &points);
    let linf_support = |u: &Wrench| cones.iter().map(|cone| support(u, cone)).sum::<f64>();

    // Edge directions of both sets: from 0 to every point, and between points.
    let mut edge_directions: Vec<Wrench> = points.clone();
    for (i, a) in points.iter().enumerate() {
        edge_directions.extend(points[i + 1..].iter().map(|b| a - b));
    }
    edge_directions.extend([Wrench::x(), Wrench::y(), Wrench::z()]);
    let weakest = Wrench::x().into();
    let mut found = ForceClosure { closed: false, q1_l1: f64::INFINITY, q1_linf: f64::INFINITY, weakest };
    let mut evaluate = |u: Wrench| {
        let (l1, linf) = (l1_support(&u), linf_support(&u));
        found.q1_linf = found.q1_linf.min(linf);
        if l1 < found.q1_l1 {
            (found.q1_l1, found.weakest) = (l1, u.into());
        }
    };
    for (i, a) in edge_directions.iter().enumerate() {
        for b in &edge_directions[i + 1..] {
            let normal = a.cross(b);
            let length = normal.dot(&normal).sqrt();
            if length > ZERO_TOLERANCE {
                evaluate(normal / length);
                evaluate(-normal / length);
            }
        }
    }
    found.closed = found.q1_l1 > ZERO_TOLERANCE;
    if !found.closed {
        (found.q1_l1, found.q1_linf) = (0.0, 0.0);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.02;

    /// Returns a contact at an angle on the disc, directed towards its centre.
    fn contact_at(degrees: f64, mu: f64) -> FrictionContact {
        let (sin, cos) = degrees.to_radians().sin_cos();
        FrictionContact { point_m: [RADIUS * cos, RADIUS * sin], push: [-cos, -sin], mu }
    }

    fn closure_of(contacts: &[FrictionContact]) -> ForceClosure {
        force_closure(contacts, [0.0; 2], RADIUS)
    }

    #[test]
    fn two_antipodal_contacts_match_the_closed_form() {
        for mu in [0.05, 0.3, 0.8, 2.0f64] {
            for turn in [0.0, 33.0, 90.0] {
                let found = closure_of(&[contact_at(turn, mu), contact_at(turn + 180.0, mu)]);
                let expected = mu / (2.0 + mu * mu).sqrt();
                assert!(found.closed && (found.q1_l1 - expected).abs() < 1e-12, "{mu}: {found:?}");
                assert!(found.q1_linf >= found.q1_l1);
            }
        }
    }

    #[test]
    fn grasps_without_force_closure_have_a_certificate() {
        // Without friction no contact exerts a moment on a disc; with friction on one side only, the disc can be lifted
        // off.
        for contacts in [
            vec![contact_at(0.0, 0.0), contact_at(120.0, 0.0), contact_at(240.0, 0.0)],
            vec![contact_at(0.0, 0.5)],
            vec![contact_at(10.0, 0.1), contact_at(-10.0, 0.1)],
            vec![],
        ] {
            let found = closure_of(&contacts);
            assert!(!found.closed && found.q1_l1 == 0.0 && found.q1_linf == 0.0, "{found:?}");
            let contact_wrenches = contacts.iter().flat_map(|contact| edges(contact, [0.0; 2], RADIUS));
            let weakest = Wrench::from(found.weakest);
            let support = contact_wrenches.map(|wrench| weakest.dot(&wrench)).fold(0.0, f64::max);
            assert!(support <= ZERO_TOLERANCE && (weakest.dot(&weakest) - 1.0).abs() < 1e-12);
        }
    }

    /// Compares the direction of the minimum with a dense search.
    #[test]
    fn finds_the_direction_of_the_minimum() {
        let contacts = [contact_at(5.0, 0.4), contact_at(131.0, 0.7), contact_at(246.0, 0.2), contact_at(300.0, 0.9)];
        let found = closure_of(&contacts);
        let cones: Vec<[Wrench; 2]> = contacts.iter().map(|contact| edges(contact, [0.0; 2], RADIUS)).collect();
        let (mut l1, mut linf) = (f64::INFINITY, f64::INFINITY);
        for i in 0..400 {
            for j in 0..400 {
                let z: f64 = -1.0 + 2.0 * (f64::from(i) + 0.5) / 400.0;
                let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / 400.0).sin_cos();
                let around = (1.0 - z * z).sqrt();
                let u = Wrench::new(around * cos, around * sin, z);
                let support: Vec<f64> =
                    cones.iter().map(|cone| cone.iter().map(|w| u.dot(w)).fold(0.0, f64::max)).collect();
                l1 = l1.min(support.iter().copied().fold(0.0, f64::max));
                linf = linf.min(support.iter().sum());
            }
        }
        assert!(found.q1_l1 <= l1 && found.q1_l1 > l1 - 0.01, "{found:?} {l1}");
        assert!(found.q1_linf <= linf && found.q1_linf > linf - 0.02, "{found:?} {linf}");
    }
}
