//! The statics of a mechanism: JSON document with units in the keys, and short tables with units.

use serde::{Serialize, Serializer};

use super::super::named::Object;
use super::{causes, force_closure_text, format_mu, millimetres};
use crate::format::numbers::{G_M_S2, format_duration, format_number, row, zero_below_resolution};
use crate::format::report::{Report, ToReport, table};
use crate::grasp::FrictionCase;
use crate::grasp::mechanism::{ActuatorAtRest, ActuatorRole, HeldContact, MechanismGrasp};
use crate::report::object::force_closure;
use crate::statics::{BodyMotion, ContactMotion, MechanismBalance, MechanismLimit, StaticsError};
use crate::units::Dimension;

/// Report of the static grasp of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismStaticsReport<'a> {
    pub grasp: &'a MechanismGrasp,
    /// Only every `stride`-th of the directions of acceleration is reported.
    stride: usize,
    /// Path of the picture, if one was written.
    pub svg: Option<String>,
}

/// Names of the columns of accelerations.
const DRIVES: [&str; 2] = ["blocked", "at_effort"];

impl<'a> MechanismStaticsReport<'a> {
    /// Creates the report with every `stride`-th of the requested directions.
    pub fn new(grasp: &'a MechanismGrasp, stride: usize) -> Self {
        MechanismStaticsReport { grasp, stride: stride.max(1), svg: None }
    }

    /// Names of the contacts with this motion at the limit.
    fn contacts_that(&self, contacts: &[(f64, f64, ContactMotion)], motion: ContactMotion) -> Vec<&'a str> {
        let all = self.grasp.contacts.iter().zip(contacts);
        all.filter(|(_, load)| load.2 == motion).map(|(contact, _)| contact.name.as_str()).collect()
    }

    /// Numbers of the contacts with this motion, as in the table of contacts.
    fn numbers_that(&self, contacts: &[(f64, f64, ContactMotion)], motion: ContactMotion) -> Vec<String> {
        let moving = contacts.iter().enumerate().filter(|(_, load)| load.2 == motion);
        moving.map(|(index, _)| (index + 1).to_string()).collect()
    }

    /// Names of the actuators that move at the limit.
    fn yielding(&self, yielding: &[usize]) -> Vec<&'a str> {
        yielding.iter().map(|index| self.grasp.actuators[*index].name.as_str()).collect()
    }

    /// Names of the actuators that pull cables.
    fn cable_actuators(&self) -> impl Iterator<Item = &'a str> {
        let actuators = self.grasp.actuators.iter().filter(|actuator| actuator.pulls_cable);
        actuators.map(|actuator| actuator.name.as_str())
    }

    fn balance_document(&self, balance: &'a MechanismBalance, brakes: &'a [String]) -> Object<'a> {
        match &balance.largest {
            MechanismLimit::Infeasible { motion, yielding } => Object::default()
                .with("balanced", "nothing")
                .with("actuators_yield", self.yielding(yielding))
                .with("motion", motion_documents(&self.grasp.bodies, motion)),
            MechanismLimit::Unlimited => Object::default().with("balanced", "any"),
            MechanismLimit::Limited {
                acceleration_m_s2,
                contacts,
                brakes: loads,
                rubbing,
                tensions_n,
                motion,
                yielding,
                gap,
                ..
            } => {
                let slipping = brakes.iter().zip(loads).filter(|(_, load)| load.slips).map(|(name, _)| name.as_str());
                let forces = self.grasp.contacts.iter().zip(contacts).map(|(contact, (normal_n, tangential_n, _))| {
                    Object::default()
                        .with("contact", contact.name.as_str())
                        .with("normal_n", *normal_n)
                        .with("tangential_n", *tangential_n)
                });
                let tensions = self.cable_actuators().zip(tensions_n);
                let tensions = tensions
                    .map(|(name, tension_n)| Object::default().with("actuator", name).with("tension_n", *tension_n));
                Object::default()
                    .with("balanced", "up to")
                    .with("acceleration_m_s2", *acceleration_m_s2)
                    .with("slips", self.contacts_that(contacts, ContactMotion::Slips))
                    .with("leaves", self.contacts_that(contacts, ContactMotion::Separates))
                    .with("brakes_slip", slipping.collect::<Vec<_>>())
                    .with("actuators_yield", self.yielding(yielding))
                    .with_some("cables_rub", (!rubbing.is_empty()).then_some(rubbing))
                    .with("forces", forces.collect::<Vec<_>>())
                    .with_some("tensions", (!tensions_n.is_empty()).then(|| tensions.collect::<Vec<_>>()))
                    .with("motion", motion_documents(&self.grasp.bodies, motion))
                    .with("gap", *gap)
            }
        }
    }

    /// The largest balanced acceleration, and the contacts, brakes and actuators at their limits; of a hand that is not at
    /// rest, the bodies and actuators that move.
    fn limit_cells(&self, balance: &MechanismBalance, brakes: &[String]) -> [String; 2] {
        let (head, parts) = match &balance.largest {
            MechanismLimit::Unlimited => return ["any", "–"].map(String::from),
            MechanismLimit::Infeasible { motion, yielding } => {
                let moving = self.grasp.bodies.iter().zip(motion).filter(|(_, rates)| **rates != [0.0; 3]);
                let moving = moving.map(|(name, _)| name.as_str()).collect();
                ("not at rest".to_string(), vec![("moves", moving), ("yields", self.yielding(yielding))])
            }
            MechanismLimit::Limited { acceleration_m_s2, contacts, brakes: loads, yielding, rubbing, .. } => {
                let numbers = |motion| self.numbers_that(contacts, motion).join(" ");
                let [slip, leave] = [ContactMotion::Slips, ContactMotion::Separates].map(numbers);
                let slipping = brakes.iter().zip(loads).filter(|(_, load)| load.slips);
                let slipping = slipping.map(|(name, _)| name.as_str()).collect();
                let contacts = [("slip", slip), ("leave", leave)];
                let contacts = contacts.into_iter().filter(|(_, numbers)| !numbers.is_empty());
                let contacts: Vec<String> = contacts.map(|(verb, numbers)| format!("{verb} {numbers}")).collect();
                let rubbing = rubbing.iter().map(String::as_str).collect();
                let others = [("brake", slipping), ("yields", self.yielding(yielding)), ("rubs", rubbing)];
                let acceleration = format_number(acceleration_m_s2 / G_M_S2, 4);
                return [acceleration, causes(contacts, others.to_vec())];
            }
        };
        [head, causes(Vec::new(), parts)]
    }

    /// The base, the actuators and what they do in both cases, and what is left out.
    fn roles(&self) -> Report {
        let grasp = self.grasp;
        let of_role = |role: ActuatorRole| grasp.actuators.iter().filter(move |actuator| actuator.role == role);
        let mut text = format!("base: {}\n", grasp.base);
        let hand: Vec<String> = of_role(ActuatorRole::Hand).map(effort).collect();
        if !hand.is_empty() {
            text.push_str(&format!("actuators of the hand, blocked or at effort: {}\n", hand.join(", ")));
        }
        let names = |role| of_role(role).map(|actuator| actuator.name.as_str()).collect::<Vec<_>>().join(", ");
        let lines = [
            ("actuators of the base, blocked in both cases", names(ActuatorRole::Base)),
            ("without effect on the grasp", names(ActuatorRole::LeftOut)),
            ("bodies that nothing connects with object and hand, left out", grasp.left_out.join(", ")),
            ("contacts with the surroundings, left out", grasp.surroundings.join(", ")),
        ];
        let given = lines.into_iter().filter(|(_, names)| !names.is_empty());
        text.extend(given.map(|(meaning, names)| format!("{meaning}: {names}\n")));
        Report::from(text)
    }

    fn friction_case(&self, case: &'a FrictionCase) -> Report {
        let mut rows = vec![row(["towards", "blocked, g", "limited by", "at effort, g", "limited by"])];
        for (angle_rad, balances) in case.directions(self.stride) {
            let angle = format!("{:.2}", angle_rad.to_degrees());
            let mut cells = vec![format!("{}°", angle.trim_end_matches('0').trim_end_matches('.'))];
            let limits = balances.into_iter().zip(&self.grasp.brakes);
            cells.extend(limits.flat_map(|(balance, brakes)| self.limit_cells(balance, brakes)));
            rows.push(cells);
        }
        let divisor = format!("{} mm", millimetres(self.grasp.radius_m));
        let closure = force_closure_text(case.mu_static, &case.force_closure, &divisor);
        Report::from(format!("{closure}\nlargest acceleration of the base that contact forces can balance\n"))
        .with(table(&rows))
        .with(Report::paragraph(
            "(0° is x, 90° is y. The limits name contacts by their numbers. An actuator yields where its effort decides: it \
             moves in the motion that a larger acceleration causes. Balancing forces exist; which of them occur depends on \
             how the grasp was closed.)\n",
        ))
    }
}

impl<'a> Serialize for MechanismStaticsReport<'a> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let grasp = self.grasp;
        let object = Object::default()
            .with("name", grasp.object.as_str())
            .with("mass_kg", grasp.mass_kg)
            .with("centre_m", grasp.centre_m)
            .with("radius_m", grasp.radius_m);
        let contact = |contact: &HeldContact| {
            Object::default()
                .with("name", contact.name.clone())
                .with("point_m", contact.at_rest.point_m)
                .with("normal", contact.at_rest.normal)
                .with("on_object", contact.push.is_some())
                .with("gap_m", contact.gap_m)
                .with("mu_static", contact.at_rest.mu)
                .with("normal_n", contact.forces_n[0])
                .with("tangential_n", contact.forces_n[1])
        };
        let closure = match &grasp.closure {
            Ok(found) => {
                let motion = found.motion.as_ref().map(|motion| motion_documents(&grasp.bodies, motion));
                Object::default()
                    .with("closed", found.closure.closed)
                    .with("coordinates", found.coordinates)
                    .with("rank", found.closure.rank)
                    .with_some("motion", motion)
            }
            Err(reason) => Object::default().with("reason", reason.to_string()),
        };
        let case = |case: &'a FrictionCase| {
            let FrictionCase { mu_static, force_closure: closure, .. } = case;
            let direction = |(angle_rad, balances): (f64, [&'a MechanismBalance; 2])| {
                let document = Object::default().with("angle_rad", angle_rad).with("direction", balances[0].direction);
                let both = DRIVES.into_iter().zip(balances).zip(&grasp.brakes);
                both.fold(document, |all, ((key, balance), brakes)| {
                    all.with(key, self.balance_document(balance, brakes))
                })
            };
            Object::default()
                .with("mu_static", *mu_static)
                .with("force_closure", force_closure(closure))
                .with("accelerations", case.directions(self.stride).map(direction).collect::<Vec<_>>())
        };
        Object::default()
            .with("scene", grasp.scene.as_str())
            .with("time_s", grasp.sample.time_s)
            .with("object", object)
            .with("base", grasp.base.as_str())
            .with("actuators", grasp.actuators.iter().map(actuator_document).collect::<Vec<_>>())
            .with("left_out", grasp.left_out.iter().map(String::as_str).collect::<Vec<_>>())
            .with("surroundings", grasp.surroundings.iter().map(String::as_str).collect::<Vec<_>>())
            .with("contacts", grasp.contacts.iter().map(contact).collect::<Vec<_>>())
            .with("form_closure", closure)
            .with("holds", grasp.friction_cases.iter().map(case).collect::<Vec<_>>())
            .with_some("svg", self.svg.as_ref())
            .serialize(serializer)
    }
}

fn actuator_document(actuator: &ActuatorAtRest) -> Object<'_> {
    let role = match actuator.role {
        ActuatorRole::Hand => "hand",
        ActuatorRole::Base => "base",
        ActuatorRole::LeftOut => "left out",
    };
    let key = if actuator.is_torque { "effort_n_m" } else { "effort_n" };
    Object::default().with("name", actuator.name.as_str()).with("role", role).with(key, actuator.effort)
}

/// Name and effort of an actuator.
fn effort(actuator: &ActuatorAtRest) -> String {
    let unit = if actuator.is_torque { "N·m" } else { "N" };
    format!("{} ({} {unit})", actuator.name, number(actuator.effort))
}

/// Velocities of the moving bodies.
fn motion_documents<'a>(bodies: &'a [String], motion: &[BodyMotion]) -> Vec<Object<'a>> {
    let moving = bodies.iter().zip(motion).filter(|(_, rates)| **rates != [0.0; 3]);
    let document = |(body, [x, y, spin]): (&'a String, &BodyMotion)| {
        Object::default().with("body", body.as_str()).with("vx_m_s", *x).with("vy_m_s", *y).with("spin_rad_s", *spin)
    };
    moving.map(document).collect()
}

/// The complete report, with a final line end.
impl ToReport for MechanismStaticsReport<'_> {
    fn report(&self) -> Report {
        let grasp = self.grasp;
        let [x, y] = grasp.centre_m.map(millimetres);
        let head = format!(
            "{}: the grasp of `{}` at {} of the run\nmass {} g, centre of mass at ({x}, {y}) mm\n",
            crate::scene::one_line(&grasp.scene),
            grasp.object,
            format_duration(grasp.sample.time_s),
            number(grasp.mass_kg * 1e3)
        );
        let mut sections = vec![Report::from(head), self.roles(), contacts(&grasp.contacts), self.closure()];
        sections.extend(grasp.friction_cases.iter().map(|case| self.friction_case(case)));
        sections.extend(self.svg.iter().map(|path| Report::from(format!("picture: {path}\n"))));
        Report::join(sections)
    }
}

impl MechanismStaticsReport<'_> {
    fn closure(&self) -> Report {
        let found = match &self.grasp.closure {
            Ok(found) => found,
            Err(reason) => return undecided(reason),
        };
        let head = format!(
            "form closure without friction, actuators blocked: {}\n",
            if found.closure.closed { "closed" } else { "not closed; a free motion:" }
        );
        let Some(motion) = &found.motion else { return Report::from(head) };
        let mut rows = vec![row(["body", "vx, mm/s", "vy, mm/s", "spin, rad/s"])];
        for (name, rates) in self.grasp.bodies.iter().zip(motion).filter(|(_, rates)| **rates != [0.0; 3]) {
            let [x, y, spin] = *rates;
            rows.push(row([name, &number(x * 1e3), &number(y * 1e3), &number(spin)]));
        }
        Report::from(head).with(table(&rows))
    }
}

fn undecided(reason: &StaticsError) -> Report {
    Report::from("form closure: not decided\n".to_string()).with(Report::paragraph(&format!("{reason}\n")))
}

fn number(value: f64) -> String {
    format_number(value, 4)
}

fn contacts(all: &[HeldContact]) -> Report {
    let head = row(["", "contact", "x, mm", "y, mm", "normal, °", "gap, µm", "μ_s", "normal, N", "friction, N"]);
    let line = |(index, contact): (usize, &HeldContact)| {
        let ([x, y], [nx, ny]) = (contact.at_rest.point_m.map(millimetres), contact.at_rest.normal);
        let angle = format!("{:.2}", ny.atan2(nx).to_degrees());
        let [normal, friction] =
            contact.forces_n.map(|force_n| number(zero_below_resolution(force_n, Dimension::Force)));
        let (gap, mu) = (format_number(contact.gap_m * 1e6, 4), format_mu(contact.at_rest.mu));
        row([&(index + 1).to_string(), &contact.name, &x, &y, &angle, &gap, &mu, &normal, &friction])
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().enumerate().map(line)).collect();
    Report::from("contacts in the frame of the world; normals towards the points\n").with(table(&rows))
}
