//! The statics of a gripper: JSON document with units in the keys, and short tables with units.

use serde::{Serialize, Serializer};

use super::super::named::Object;
use super::{causes, closure_document, closure_text, force_closure_text, format_mu, millimetres};
use crate::format::numbers::{G_M_S2, format_duration, format_number, row, zero_below_resolution};
use crate::format::report::{Report, ToReport, table};
use crate::grasp::FrictionCase;
use crate::grasp::finger::Palm;
use crate::grasp::gripper::{ContactLoad, GripperGrasp, MotorAtRest, ObjectContact, PostureSource};
use crate::report::object::force_closure;
use crate::scene::HandContact;
use crate::statics::{Blocked, BrakeLoad, ContactMotion, MechanismBalance, MechanismLimit, StaticsError};
use crate::trace::FingerState;
use crate::units::Dimension;

/// Report of the static grasp of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperStaticsReport<'a> {
    pub grasp: &'a GripperGrasp,
    /// Only every `stride`-th of the directions of acceleration is reported.
    stride: usize,
    /// Path of the picture, if one was written.
    pub svg: Option<String>,
}

impl<'a> GripperStaticsReport<'a> {
    /// Creates the report with every `stride`-th of the requested directions.
    pub fn new(grasp: &'a GripperGrasp, stride: usize) -> Self {
        GripperStaticsReport { grasp, stride: stride.max(1), svg: None }
    }

    /// Support by the palm. An active contact may penetrate by some micrometres; the object rests on the palm
    /// nevertheless.
    fn palm(&self) -> Palm {
        match self.grasp.contacts.iter().any(|contact| contact.id == HandContact::Palm) {
            true => Palm::Resting,
            false => Palm::None,
        }
    }
}

impl<'a> Serialize for GripperStaticsReport<'a> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let grasp = self.grasp;
        let finger = |finger: &FingerState| {
            Object::default()
                .with("q11_rad", finger.q11_rad)
                .with("q21_rad", finger.q21_rad)
                .with("q12_rad", finger.q12_rad)
                .with("q22_rad", finger.q22_rad)
        };
        let (source, time_s, fate) = match grasp.source {
            PostureSource::Run { time_s, fate } => ("run", Some(time_s), Some(fate.name())),
            PostureSource::Geometric => ("geometric", None, None),
            PostureSource::Explicit => ("given", None, None),
        };
        let [x_m, y_m] = grasp.sample.body(0).centre_m;
        let posture = Object::default()
            .with("source", source)
            .with("time_s", time_s)
            .with("fate", fate)
            .with("right", finger(&grasp.sample.finger(0)))
            .with("left", finger(&grasp.sample.finger(1)))
            .with("x_m", x_m)
            .with("y_m", y_m)
            .with("mass_kg", grasp.mass_kg)
            .with("gravity_m_s2", grasp.gravity_m_s2);
        let motor = |motor: &'a MotorAtRest| {
            // The infinite brake of a blocked motor becomes null.
            let [min_n_m, max_n_m] = motor.brake_n_m;
            Object::default()
                .with("motor", motor.name.as_str())
                .with("torque_n_m", motor.torque_n_m)
                .with("brake_min_n_m", min_n_m)
                .with("brake_max_n_m", max_n_m)
        };
        let closure = |(blocked, found): &'a (Blocked, Result<_, StaticsError>)| {
            Object::default()
                .with("blocked", if *blocked == Blocked::Outputs { "outputs" } else { "input" })
                .with("closure", found.as_ref().ok().map(|found| closure_document(found, &self.palm())))
                .with_some("reason", found.as_ref().err().map(StaticsError::to_string))
        };
        let friction_case = |case: &'a FrictionCase| {
            let direction = |(angle_rad, [blocked, at_torque]): (f64, [&'a MechanismBalance; 2])| {
                Object::default()
                    .with("angle_rad", angle_rad)
                    .with("direction", blocked.direction)
                    .with("blocked", self.balance_document(blocked))
                    .with("at_torque", self.balance_document(at_torque))
            };
            Object::default()
                .with("mu_static", case.mu_static)
                .with("force_closure", force_closure(&case.force_closure))
                .with("accelerations", case.directions(self.stride).map(direction).collect::<Vec<_>>())
        };
        Object::default()
            .with("scene", &grasp.scene)
            .with("posture", posture)
            .with("motors", grasp.motors.iter().map(motor).collect::<Vec<_>>())
            .with("contacts", grasp.contacts.iter().map(contact_document).collect::<Vec<_>>())
            .with("form_closure", grasp.closures.iter().map(closure).collect::<Vec<_>>())
            .with("holds", grasp.friction_cases.iter().map(friction_case).collect::<Vec<_>>())
            .with_some("svg", self.svg.as_ref())
            .serialize(serializer)
    }
}

fn contact_document(contact: &ObjectContact) -> Object<'_> {
    Object::default()
        .with("place", contact.id.name())
        .with("point_m", contact.point.point_m)
        .with("normal", contact.point.normal)
        .with("gap_m", contact.point.gap_m)
        .with("mu_static", contact.mu_static)
        .with("normal_n", contact.forces_n.map(|[normal_n, _]| normal_n))
        .with("tangential_n", contact.forces_n.map(|[_, tangential_n]| tangential_n))
}

/// JSON object of the force of a contact; a joint limit has a torque.
fn force_document(load: &ContactLoad) -> Object<'static> {
    let force = Object::default().with("place", load.id.name());
    match load.id.is_stop() {
        true => force.with("torque_n_m", load.normal_n),
        false => force.with("normal_n", load.normal_n).with("tangential_n", load.tangential_n),
    }
}

/// Names of the contacts with this motion at the limit.
fn contacts_that(loads: &[ContactLoad], motion: ContactMotion) -> Vec<String> {
    loads.iter().filter(|load| load.motion == motion).map(|load| load.id.name()).collect()
}

/// The complete report, with a final line end.
impl ToReport for GripperStaticsReport<'_> {
    fn report(&self) -> Report {
        let head = format!("{}: the grasp of its object at rest\n", crate::scene::one_line(&self.grasp.scene)).into();
        let motors = self.grasp.motors.iter().map(motor).collect::<String>().into();
        let mut sections = vec![head, posture(self.grasp), motors, contacts(&self.grasp.contacts)];
        for (blocked, found) in &self.grasp.closures {
            let blocked = match blocked {
                Blocked::Outputs => "both driven links blocked",
                Blocked::Input => "the differential's input blocked",
            };
            sections.push(match found {
                Ok(found) => closure_text(found, &self.palm(), &format!("form closure, {blocked}"), None),
                Err(reason) => Report::from(format!("form closure, {blocked}: not decided\n"))
                    .with(Report::paragraph(&format!("{reason}\n"))),
            });
        }
        sections.extend(self.grasp.friction_cases.iter().map(|case| self.friction_case(case)));
        sections.extend(self.svg.iter().map(|path| Report::from(format!("picture: {path}\n"))));
        Report::join(sections)
    }
}

impl<'a> GripperStaticsReport<'a> {
    /// Names of the motors whose brakes slip at the limit.
    fn slipping_brakes(&self, brakes: &[BrakeLoad]) -> Vec<&'a str> {
        let slipping = brakes.iter().zip(&self.grasp.motors).filter(|(brake, _)| brake.slips);
        slipping.map(|(_, motor)| motor.name.as_str()).collect()
    }

    /// JSON object of the largest balanced acceleration: "up to" it, "any", or "nothing"; with the contacts and brakes at
    /// their limits, forces that balance it (not necessarily unique), and the motion that a larger one causes.
    fn balance_document(&self, balance: &MechanismBalance) -> Object<'a> {
        let without_limit = |balanced: &'static str| {
            let none = || Vec::<String>::new();
            let document = Object::default().with("balanced", balanced).with("acceleration_m_s2", None::<f64>);
            document.with("slips", none()).with("leaves", none()).with("brakes_slip", none())
        };
        match &balance.largest {
            MechanismLimit::Infeasible { .. } => without_limit("nothing"),
            MechanismLimit::Unlimited => without_limit("any"),
            MechanismLimit::Limited { acceleration_m_s2, contacts, limits, brakes, motion, gap, .. } => {
                let loads = self.grasp.loads(contacts, limits);
                let motion = self.grasp.hand_motion(motion);
                let forces: Vec<_> = loads.iter().map(force_document).collect();
                let motion = Object::default()
                    .with("object_m_s", motion.object_m_s)
                    .with("spin_rad_s", motion.spin_rad_s)
                    .with("right_rad_s", motion.fingers_rad_s[0])
                    .with("left_rad_s", motion.fingers_rad_s[1]);
                Object::default()
                    .with("balanced", "up to")
                    .with("acceleration_m_s2", *acceleration_m_s2)
                    .with("slips", contacts_that(&loads, ContactMotion::Slips))
                    .with("leaves", contacts_that(&loads, ContactMotion::Separates))
                    .with("brakes_slip", self.slipping_brakes(brakes))
                    .with_some("forces", Some(forces).filter(|forces| !forces.is_empty()))
                    .with("motion", motion)
                    .with("gap", *gap)
            }
        }
    }

    /// The largest balanced acceleration, and the contacts and brakes at their limits, by their short names.
    fn limit_cells(&self, balance: &MechanismBalance) -> [String; 2] {
        let (acceleration_m_s2, loads, brakes) = match &balance.largest {
            MechanismLimit::Unlimited => return ["any", "–"].map(String::from),
            MechanismLimit::Infeasible { .. } => return ["not at rest", "–"].map(String::from),
            MechanismLimit::Limited { acceleration_m_s2, contacts, limits, brakes, .. } => {
                (acceleration_m_s2, self.grasp.loads(contacts, limits), brakes)
            }
        };
        let [slip, leave] =
            [ContactMotion::Slips, ContactMotion::Separates].map(|motion| contacts_that(&loads, motion));
        let [slip, leave] = [&slip, &leave].map(|names| names.iter().map(|name| short_name(name)).collect());
        let names = vec![("slip", slip), ("leave", leave), ("brake", self.slipping_brakes(brakes))];
        [format_number(acceleration_m_s2 / G_M_S2, 4), causes(Vec::new(), names)]
    }

    fn friction_case(&self, case: &FrictionCase) -> Report {
        let mut rows = vec![row(["towards", "", "blocked, g", "limited by", "at torque, g", "limited by"])];
        for (angle_rad, balances) in case.directions(self.stride) {
            let angle = format!("{:.2}", angle_rad.to_degrees());
            let mut cells = vec![format!("{}°", angle.trim_end_matches('0').trim_end_matches('.'))];
            cells.push(direction_name(balances[0].direction).to_string());
            cells.extend(balances.into_iter().flat_map(|balance| self.limit_cells(balance)));
            rows.push(cells);
        }
        let closure = force_closure_text(case.mu_static, &case.force_closure, "radius");
        Report::from(format!("{closure}\nlargest acceleration of the palm that contact forces can balance\n"))
        .with(table(&rows))
        .with(Report::paragraph(
            "(0° is x, along the palm to the right; 90° is y, out of the palm; a hanging gripper is lifted towards 270°. Balancing forces \
             exist; which of them occur depends on how the hand was closed.)\n",
        ))
    }
}

fn number(value: f64) -> String {
    format_number(value, 4)
}

fn posture(grasp: &GripperGrasp) -> Report {
    let head = match grasp.source {
        PostureSource::Run { time_s, fate } => {
            format!("posture at {} of the run; object {}\n", format_duration(time_s), fate.name())
        }
        PostureSource::Geometric => {
            "posture: all phalanges in contact with the object at its position in the scene\n".to_string()
        }
        PostureSource::Explicit => "posture as given\n".to_string(),
    };
    let mut rows = vec![row(["finger", "q11, °", "q21, °", "q12, °", "q22, °"])];
    for (name, finger) in ["right", "left"].into_iter().zip(grasp.sample.fingers()) {
        let [q11, q21, q12, q22] = [finger.q11_rad, finger.q21_rad, finger.q12_rad, finger.q22_rad]
            .map(|angle_rad| format!("{:.4}", angle_rad.to_degrees()));
        rows.push(row([name, &q11, &q21, &q12, &q22]));
    }
    let ([x, y], [gx, gy]) = (grasp.sample.body(0).centre_m.map(millimetres), grasp.gravity_m_s2.map(number));
    let mass = number(grasp.mass_kg * 1e3);
    let object = format!("object of {mass} g at ({x}, {y}) mm, gravity ({gx}, {gy}) m/s² in the palm's frame\n");
    Report::from(head).with(table(&rows)).with(object)
}

fn motor(motor: &MotorAtRest) -> String {
    let name = if motor.name == "input" { "input of the differential" } else { &motor.name };
    let [torque, brake] = [motor.torque_n_m, motor.brake_n_m[1]].map(|torque_n_m| number(torque_n_m * 1e3));
    let blocked = match motor.brake_n_m {
        [min_n_m, max_n_m] if !(min_n_m.is_finite() && max_n_m.is_finite()) => {
            "no brake in the scene, so \"blocked\" means unlimited torque".to_string()
        }
        [min_n_m, _] if min_n_m < 0.0 => format!("a brake that holds {brake} N·mm"),
        _ => format!("a brake that holds {brake} N·mm against opening only"),
    };
    format!("motor, {name}: {torque} N·mm; {blocked}\n")
}

/// Short name of a contact; that of a phalanx contains its link.
fn short_name(contact: &str) -> &str {
    match contact {
        "right_proximal" => "R21",
        "right_distal" => "R22",
        "right_limit" => "R limit",
        "left_proximal" => "L21",
        "left_distal" => "L22",
        "left_limit" => "L limit",
        other => other,
    }
}

fn contacts(all: &[ObjectContact]) -> Report {
    let has_forces = all.iter().any(|contact| contact.forces_n.is_some());
    let mut head = row(["contact", "x, mm", "y, mm", "normal, °", "gap, µm", "μ_s"]);
    head.extend(has_forces.then(|| row(["normal, N", "friction, N"])).into_iter().flatten());
    let line = |contact: &ObjectContact| {
        let name = match contact.id.name() {
            palm if contact.id == HandContact::Palm => palm,
            name => format!("{} {}", short_name(&name), name.replace('_', " ")),
        };
        let ([x, y], [nx, ny]) = (contact.point.point_m.map(millimetres), contact.point.normal);
        let angle = format!("{:.2}", ny.atan2(nx).to_degrees());
        let gap = format_number(contact.point.gap_m * 1e6, 4);
        let mut cells = row([&name, &x, &y, &angle, &gap, &format_mu(contact.mu_static)]);
        let forces = contact.forces_n.into_iter().flatten();
        cells.extend(forces.map(|force_n| number(zero_below_resolution(force_n, Dimension::Force))));
        cells
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    let note = "(forces of the run; friction on phalanx and palm is along t = (n_y, −n_x), mirrored on the left)\n";
    let head = Report::from("contacts in the palm's frame; normals into the object\n");
    head.with(table(&rows)).with(has_forces.then_some(note))
}

/// Name of a direction for a hanging gripper.
fn direction_name([x, y]: [f64; 2]) -> &'static str {
    match (x, y) {
        (1.0, 0.0) => "right",
        (-1.0, 0.0) => "left",
        (0.0, 1.0) => "down",
        (0.0, -1.0) => "up",
        _ => "",
    }
}
