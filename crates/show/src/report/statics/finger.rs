//! The statics of a finger: JSON document with units in the keys, and short tables with units.

use serde::{Serialize, Serializer};

use super::super::named::Object;
use super::{closure_document, closure_text, format_mu, millimetres};
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, ToReport, table, table_of};
use crate::grasp::finger::{DriveAtRest, Forces, Grasp, SpringAtRest};
use crate::gripper::{Posture, SpringKind};
use crate::statics::{Ejection, Equilibrium};

/// Report of the static grasp of a finger.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticsReport<'a> {
    pub grasp: &'a Grasp,
    /// Path of the picture, if one was written.
    pub svg: Option<String>,
}

impl<'a> StaticsReport<'a> {
    pub fn new(grasp: &'a Grasp) -> Self {
        StaticsReport { grasp, svg: None }
    }

    /// Forces per 1 N·m of motor torque without spring and friction.
    fn unit_torque_forces_n(&self) -> [f64; 3] {
        let forces = &self.grasp.unit_torque_forces;
        [forces.f21_n, forces.f22_n, forces.pfp_n]
    }
}

impl Serialize for StaticsReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Grasp { scene, end, contacts: [proximal, distal], drive, forces, palm, .. } = self.grasp;
        let spring = |at_rest: SpringAtRest| {
            let [kind, placement] = spring_names(&at_rest);
            Object::default()
                .with("type", kind)
                .with("placement", placement)
                .with("torque_n_m", at_rest.torque_n_m)
                .with("loads_n_m", at_rest.loads_n_m)
        };
        let posture = Object::default()
            .with("q11_rad", end.posture.q11_rad)
            .with("q21_rad", end.posture.q21_rad)
            .with("q12_rad", end.posture.q12_rad)
            .with("q22_rad", end.posture.q22_rad)
            .with("phi_c_rad", end.phi_c_rad)
            .with("proximal", proximal)
            .with("distal", distal);
        let drive = Object::default()
            .with("motor_n_m", drive.motor_n_m)
            .with("motor_min_n_m", drive.motor_min_n_m)
            .with("spring", drive.spring.map(spring))
            .with("loads_n_m", drive.loads_n_m);
        Object::default()
            .with("scene", scene)
            .with("final", posture)
            .with("drive", drive)
            .with("forces", forces.iter().map(forces_document).collect::<Vec<_>>())
            .with("forces_per_n_m", self.unit_torque_forces_n())
            .with("form_closure", closure_document(&self.grasp.closure, palm))
            .with_some("svg", self.svg.as_ref())
            .serialize(serializer)
    }
}

fn forces_document(Forces { mu_static, equilibrium, birglen }: &Forces) -> Object<'_> {
    let [f1_n, f2_n] = birglen.forces_n;
    let birglen = Object::default()
        .with("jacobian_m", birglen.jacobian_m)
        .with("transmission", birglen.transmission)
        .with("transmission_inverse", birglen.transmission_inverse)
        .with("torques_n_m", birglen.torques_n_m)
        .with("forces_n", birglen.forces_n)
        .with("difference_n", [f1_n - equilibrium.f21_n, f2_n - equilibrium.f22_n]);
    Object::default()
        .with("mu_static", mu_static)
        .with("f21_n", equilibrium.f21_n)
        .with("f22_n", equilibrium.f22_n)
        .with("pfp_n", equilibrium.pfp_n)
        .with("force_positive", equilibrium.is_force_positive())
        .with("palm_force_positive", equilibrium.is_palm_force_positive())
        .with("ejection", ejection(equilibrium).0)
        .with("birglen", birglen)
}

/// Name of an ejection, and its cause.
fn ejection(equilibrium: &Equilibrium) -> (&'static str, Option<&'static str>) {
    const PROXIMAL: &str = "the proximal phalanx would have to pull: it loses contact, and the object slides along the distal phalanx (ejection)";
    const DISTAL: &str =
        "the distal phalanx would have to pull: the spring opens it against the motor, and the object is released";
    match equilibrium.ejection() {
        Ejection::None => ("none", None),
        Ejection::Proximal => ("proximal", Some(PROXIMAL)),
        Ejection::Distal => ("distal", Some(DISTAL)),
        Ejection::Both => ("both", Some("both phalanges would have to pull: the finger opens")),
    }
}

/// Kind and placement of a spring, as in scene files.
fn spring_names(at_rest: &SpringAtRest) -> [&'static str; 2] {
    let kind = match at_rest.spring.kind {
        SpringKind::Constant { .. } => "constant",
        SpringKind::Torsional { .. } => "torsional",
    };
    [kind, at_rest.spring.placement.name()]
}

impl ToReport for StaticsReport<'_> {
    fn report(&self) -> Report {
        let Grasp { scene, drive: loads, forces: all, palm, closure, .. } = self.grasp;
        Report::join([
            format!("{}: the grasp at rest\n", crate::scene::one_line(scene)).into(),
            posture(self.grasp),
            drive(loads).into(),
            forces(all),
            birglen(all),
            closure_text(closure, palm, "form closure of two fingers", Some(self.unit_torque_forces_n())),
            self.svg.as_ref().map(|path| format!("picture: {path}\n")).into(),
        ])
    }
}

fn number(value: f64) -> String {
    format_number(value, 5)
}

fn posture(Grasp { end, contacts: [proximal, distal], .. }: &Grasp) -> Report {
    let Posture { q11_rad, q21_rad, q12_rad, q22_rad } = end.posture;
    let angles = [("q11", q11_rad), ("q21", q21_rad), ("q12", q12_rad), ("q22", q22_rad), ("phi_c", end.phi_c_rad)]
        .map(|(name, angle_rad)| format!("{name} {:.4}°", angle_rad.to_degrees()));
    let table = table_of(
        [("proximal", proximal), ("distal", distal)],
        &[
            ("contact", &|(name, _)| name.to_string()),
            ("from joint, mm", &|(_, contact)| millimetres(contact.from_joint_m)),
            ("phalanx length, mm", &|(_, contact)| millimetres(contact.phalanx_m)),
            ("x, mm", &|(_, contact)| millimetres(contact.point_m[0])),
            ("y, mm", &|(_, contact)| millimetres(contact.point_m[1])),
        ],
    );
    Report::from(format!("final posture: {}\n", angles.join(", "))).with(table)
}

fn drive(drive: &DriveAtRest) -> String {
    let milli = |torque_n_m: f64| number(torque_n_m * 1e3);
    let spring = drive.spring.map_or("no spring".to_string(), |at_rest| {
        let [kind, placement] = spring_names(&at_rest);
        format!("{kind} spring {} N·mm at {placement}", milli(at_rest.torque_n_m))
    });
    let [motor, q11, q21] = [drive.motor_n_m, drive.loads_n_m[0], drive.loads_n_m[1]].map(milli);
    let limit = match drive.motor_min_n_m {
        Some(min_n_m) if min_n_m > 0.0 => {
            format!("the distal phalanx pushes the object at motor torques above {} N·mm\n", milli(min_n_m))
        }
        Some(_) => String::new(),
        None => {
            "the distal phalanx pushes the object only at a negative motor torque: q22 decreases as q11 increases\n"
                .to_string()
        }
    };
    format!("motor {motor} N·mm, {spring}: together ({q11}, {q21}) N·mm on (q11, q21)\n{limit}")
}

fn friction([proximal, distal]: [f64; 2]) -> String {
    let [proximal, distal] = [proximal, distal].map(format_mu);
    if proximal == distal { proximal } else { format!("{proximal}, {distal}") }
}

fn forces(all: &[Forces]) -> Report {
    let yes_or_no = |value: bool| if value { "yes" } else { "no" };
    let mut rows = vec![row(["μ_s", "F21, N", "F22, N", "force positive", "PFP, N", "palm force positive"])];
    let mut notes = String::new();
    for Forces { mu_static, equilibrium, .. } in all {
        let [f21, f22, pfp] = [equilibrium.f21_n, equilibrium.f22_n, equilibrium.pfp_n].map(number);
        let positive = yes_or_no(equilibrium.is_force_positive());
        let palm_positive = yes_or_no(equilibrium.is_palm_force_positive());
        rows.push(row([&friction(*mu_static), &f21, &f22, positive, &pfp, palm_positive]));
        if let (_, Some(cause)) = ejection(equilibrium) {
            notes.push_str(&format!("μ_s {}: {cause}\n", friction(*mu_static)));
        }
    }
    Report::from("contact forces at rest, without weight\n").with(table(&rows)).with(notes)
}

fn birglen(all: &[Forces]) -> Report {
    let text = Report::from("Birglen's frame: phalanges of zero width, θ = (q21, q22)\n");
    let Some(Forces { birglen: first, .. }) = all.first() else {
        return text;
    };
    let [t21, t22] = first.torques_n_m.map(|torque_n_m| number(torque_n_m * 1e3));
    let transmission = matrix(&first.transmission, 1.0);
    let difference = |force_n: f64, other_n: f64| match force_n - other_n {
        // A difference of this size is rounding error.
        difference if difference.abs() <= 1e-9 * force_n.abs().max(1.0) => "0".to_string(),
        difference => format_number(difference, 3),
    };
    let table = table_of(
        all,
        &[
            ("μ_s", &|forces| friction(forces.mu_static)),
            ("Jacobian J, mm", &|forces| matrix(&forces.birglen.jacobian_m, 1e3)),
            ("f1, N", &|forces| number(forces.birglen.forces_n[0])),
            ("f2, N", &|forces| number(forces.birglen.forces_n[1])),
            ("f1 − F21, N", &|forces| difference(forces.birglen.forces_n[0], forces.equilibrium.f21_n)),
            ("f2 − F22, N", &|forces| difference(forces.birglen.forces_n[1], forces.equilibrium.f22_n)),
        ],
    );
    let note = "(f differs from F by the friction on the surface of a phalanx, whose lever arm is the half width)\n";
    text.with(format!("transmission T = {transmission}, torques t = ({t21}, {t22}) N·mm\n"))
        .with(table)
        .with(all.iter().any(|forces| forces.mu_static != [0.0; 2]).then_some(note))
}

fn matrix(rows: &[[f64; 2]; 2], factor: f64) -> String {
    let [[a, b], [c, d]] = rows.map(|row| row.map(|value| number(value * factor)));
    format!("[{a} {b}; {c} {d}]")
}
