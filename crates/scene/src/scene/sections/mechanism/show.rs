//! A mechanism as the sections of a scene file.

use toml::{Table, Value};

use super::joint::joint_words;
use super::outline::outline_settings;
use super::tendon::tendon_settings;
use crate::drive::Brake;
use crate::law::{ContactLaw, Damping, FrictionLaw, NormalLaw};
use crate::mechanism::{
    Actuator, Body, Command, ContactPair, Coupling, Joint, JointCombination, JointKind, Mechanism, Rotor, Spring,
    SpringKind, TendonActuator,
};
use crate::scene::Profile;
use crate::scene::quantity::Keyword;
use crate::scene::sections::{law, list, table};
use crate::units::{Dimension, format};

/// Settings of a mechanism by section.
pub fn mechanism_settings(mechanism: &Mechanism) -> Table {
    let laws = Laws::of(mechanism);
    let named = |entries: Vec<(String, Table)>| -> Value {
        entries.into_iter().map(|(name, settings)| (name, Value::from(settings))).collect::<Table>().into()
    };
    let body_name = |body: &Option<usize>| Value::from(mechanism.body_name(*body));
    let joint = |joint: &Joint| {
        let (linear, _) = joint_words(joint.kind);
        let units = Units { linear };
        let mut settings = table([
            ("type", if linear { "prismatic" } else { "revolute" }.into()),
            ("bodies", joint.bodies.iter().map(body_name).collect::<Vec<_>>().into()),
            ("points", joint.points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
            ("offset", joint.offset_rad.into()),
        ]);
        if let JointKind::Prismatic { axis_rad } = joint.kind {
            settings.insert("axis".into(), axis_rad.into());
        }
        let given = |value: f64| Some(value).filter(|value| *value != 0.0);
        let bristle = joint.friction.and_then(|law| law.bristle);
        if let Some(FrictionLaw { v_static_m_s, v_dynamic_m_s, .. }) = joint.friction {
            let rates = [v_static_m_s, v_dynamic_m_s].map(|rate| Value::from(units.text(rate, Kind::Rate)));
            settings.insert("friction_rates".into(), rates.to_vec().into());
        }
        settings.extend(units.texts([
            ("start", joint.start, Kind::Coordinate),
            ("start_rate", given(joint.start_rate).or(joint.start.and(Some(0.0))), Kind::Rate),
            ("damping", given(joint.damping), Kind::Damping),
            ("armature", given(joint.armature), Kind::Inertia),
            ("friction", joint.friction.map(|law| law.mu_dynamic), Kind::Effort),
            ("static_friction", joint.friction.map(|law| law.mu_static), Kind::Effort),
            ("friction_stiffness", bristle.map(|of| of.damping_n_s_per_m / of.relaxation_s), Kind::Stiffness),
            ("lower", joint.lower, Kind::Coordinate),
            ("upper", joint.upper, Kind::Coordinate),
        ]));
        if let (Some(normal), true) = (joint.limit, joint.lower.or(joint.upper).is_some()) {
            settings.insert("stop".into(), laws.name(&ContactLaw { normal, friction: None }, linear).into());
        }
        settings
    };
    let is_jointed = |body: usize| mechanism.joints.iter().any(|joint| joint.bodies.contains(&Some(body)));
    let body = |(index, body): (usize, &Body)| {
        let [x, y, angle] = body.pose;
        let mut settings = table([
            ("mass", body.mass_kg.into()),
            ("inertia", body.inertia_kg_m2.into()),
            ("com", list(body.com_m)),
            ("outlines", named(body.outlines.iter().map(outline_settings).collect())),
        ]);
        let mut pose = table([("at", list([x, y])), ("angle", angle.into())]);
        if is_jointed(index) {
            settings.insert("guess".into(), pose.into());
        } else {
            let [vx, vy, spin] = body.rate;
            pose.extend(table([("velocity", list([vx, vy])), ("spin", spin.into())]));
            settings.insert("start".into(), pose.into());
        }
        (body.name.clone(), settings)
    };
    let spring = |spring: &Spring| {
        let (mut settings, linear, preload) = match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                let (mut settings, linear) = combination_settings(on, mechanism);
                settings.insert("type".into(), "torsional".into());
                (settings, linear, Some(*preload))
            }
            SpringKind::Linear { bodies, points_m } => (
                table([
                    ("type", "linear".into()),
                    ("bodies", bodies.iter().map(body_name).collect::<Vec<_>>().into()),
                    ("points", points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
                ]),
                true,
                None,
            ),
        };
        settings.extend(Units { linear }.texts([
            ("stiffness", Some(spring.stiffness), Kind::Stiffness),
            ("damping", Some(spring.damping), Kind::Damping),
            ("rest", Some(spring.rest), Kind::Coordinate),
            ("torque", preload, Kind::Effort),
        ]));
        (spring.name.clone(), settings)
    };
    let coupling = |coupling: &Coupling| {
        let (mut settings, linear) = joints_settings(&coupling.on, mechanism);
        settings.extend(Units { linear }.texts([("value", Some(coupling.on.offset), Kind::Coordinate)]));
        (coupling.name.clone(), settings)
    };
    let rotor = |rotor: &Rotor| {
        let (mut settings, linear) = joints_settings(&rotor.on, mechanism);
        settings.extend(Units { linear }.texts([("inertia", Some(rotor.inertia), Kind::Inertia)]));
        (rotor.name.clone(), settings)
    };
    let actuators = mechanism.actuators.iter().map(|each| actuator_settings(each, mechanism));
    let pulls = mechanism.tendons.iter().filter_map(|tendon| {
        let TendonActuator { name, tension } = tendon.actuator.as_ref()?;
        let mut settings = table([("tendon", tendon.name.as_str().into())]);
        insert_profile(&mut settings, tension, "tension", &Value::from);
        Some((name.clone(), settings))
    });
    let mut file = table([
        ("bodies", named(mechanism.bodies.iter().enumerate().map(body).collect())),
        ("joints", named(mechanism.joints.iter().map(|each| (each.name.clone(), joint(each))).collect())),
        ("springs", named(mechanism.springs.iter().map(spring).collect())),
        ("tendons", named(mechanism.tendons.iter().map(|each| tendon_settings(each, mechanism)).collect())),
        ("couplings", named(mechanism.couplings.iter().map(coupling).collect())),
        ("actuators", named(actuators.chain(pulls).collect())),
        ("rotors", named(mechanism.rotors.iter().map(rotor).collect())),
        ("laws", named(laws.settings())),
    ]);
    let ground = named(mechanism.ground_outlines.iter().map(outline_settings).collect());
    file.insert("ground".into(), table([("outlines", ground)]).into());
    let contact = |contact: &ContactPair| {
        Value::from(table([
            ("points", mechanism.outline_name(contact.points).into()),
            ("face", mechanism.outline_name(contact.face).into()),
            ("law", laws.name(&contact.law, true).into()),
            ("at", contact.force_point.keyword().into()),
            ("rolling_arm", contact.rolling.map_or(f64::NAN, |law| law.mu_static).into()),
            ("rolling_rate", contact.rolling.map_or(f64::NAN, |law| law.v_static_m_s).into()),
        ]))
    };
    file.insert("contacts".into(), mechanism.contacts.iter().map(contact).collect::<Vec<_>>().into());
    file
}

fn actuator_settings(actuator: &Actuator, mechanism: &Mechanism) -> (String, Table) {
    let (mut settings, linear) = combination_settings(&actuator.on, mechanism);
    let units = Units { linear };
    let (profile, key, kind) = match &actuator.command {
        Command::Effort(profile) => (profile, if linear { "force" } else { "torque" }, Kind::Effort),
        Command::Servo { kp, kd, target, target_rate, rate_hz } => {
            settings.extend(units.texts([("target_rate", *target_rate, Kind::Rate)]));
            settings.extend(rate_hz.map(|rate_hz| ("rate".to_string(), format(rate_hz, Dimension::Frequency).into())));
            settings.extend(units.texts([("kp", Some(*kp), Kind::Stiffness), ("kd", Some(*kd), Kind::Damping)]));
            (target, "target", Kind::Coordinate)
        }
    };
    insert_profile(&mut settings, profile, key, &|value| units.text(value, kind).into());
    settings.extend(
        units.texts([("limit", actuator.limit, Kind::Effort), ("no_load_speed", actuator.no_load_speed, Kind::Rate)]),
    );
    if let Some(brake) = actuator.brake {
        let Brake { torque_n_m, start_s, rise_s, release_s, one_way, v_static_rad_s, bristle } = brake;
        let mut brake = table([
            ("at", start_s.into()),
            ("rise", rise_s.into()),
            ("release", release_s.unwrap_or(f64::NAN).into()),
            ("one_way", one_way.into()),
            ("relaxation", bristle.map_or(f64::NAN, |bristle| bristle.relaxation_s).into()),
        ]);
        let stiffness = bristle.map(|bristle| bristle.damping_n_s_per_m / bristle.relaxation_s);
        brake.extend(units.texts([
            ("limit", Some(torque_n_m), Kind::Effort),
            ("rate", Some(v_static_rad_s), Kind::Rate),
            ("stiffness", stiffness, Kind::Stiffness),
        ]));
        settings.insert("brake".into(), brake.into());
    }
    (actuator.name.clone(), settings)
}

/// Settings of the joints and factors of a combination, and whether it has the units of a prismatic joint.
fn joints_settings(on: &JointCombination, mechanism: &Mechanism) -> (Table, bool) {
    let name = |(joint, _): &(usize, f64)| Value::from(mechanism.joints[*joint].name.as_str());
    let names: Vec<Value> = on.terms.iter().map(name).collect();
    let linear = on.terms.first().is_some_and(|(joint, _)| joint_words(mechanism.joints[*joint].kind).0);
    (table([("joints", names.into()), ("factors", list(on.terms.iter().map(|(_, factor)| *factor)))]), linear)
}

/// The same for a spring or an actuator, which name a single joint by itself.
fn combination_settings(on: &JointCombination, mechanism: &Mechanism) -> (Table, bool) {
    let (mut settings, linear) = joints_settings(on, mechanism);
    if let Some(joint) = on.joint() {
        settings = table([("joint", mechanism.joints[joint].name.as_str().into())]);
    } else {
        settings.extend(Units { linear }.texts([("offset", Some(on.offset), Kind::Coordinate)]));
    }
    (settings, linear)
}

/// Inserts a constant, or times and values.
fn insert_profile(settings: &mut Table, profile: &Profile, key: &str, setting: &dyn Fn(f64) -> Value) {
    match profile {
        Profile::Table { points, .. } => {
            settings.insert("times".into(), list(points.iter().map(|point| point.0)));
            let values: Vec<Value> = points.iter().map(|point| setting(point.1)).collect();
            settings.insert(format!("{key}s"), values.into());
        }
        other => _ = settings.insert(key.into(), setting(other.at(0.0).0)),
    }
}

/// Kind of a quantity whose dimension depends on the joint.
#[derive(Clone, Copy)]
enum Kind {
    Coordinate,
    Rate,
    Stiffness,
    Damping,
    Inertia,
    Effort,
}

/// Units of a joint that slides or turns.
#[derive(Clone, Copy)]
struct Units {
    linear: bool,
}

impl Units {
    fn text(self, si: f64, kind: Kind) -> String {
        use Dimension as D;
        let [angular, linear] = match kind {
            Kind::Coordinate => [D::Angle, D::Length],
            Kind::Rate => [D::AngularRate, D::Speed],
            Kind::Stiffness => [D::AngularStiffness, D::LinearStiffness],
            Kind::Damping => [D::AngularDamping, D::LinearDamping],
            Kind::Inertia => [D::Inertia, D::Mass],
            Kind::Effort => [D::Torque, D::Force],
        };
        format(si, if self.linear { linear } else { angular })
    }

    /// Texts of the given values by key.
    fn texts<const N: usize>(self, values: [(&str, Option<f64>, Kind); N]) -> Table {
        let text =
            |(key, value, kind): (&str, Option<f64>, Kind)| Some((key.to_owned(), self.text(value?, kind).into()));
        values.into_iter().filter_map(text).collect()
    }
}

/// All different laws of a mechanism, which get names by their order, and whether they are those of contacts.
struct Laws(Vec<(ContactLaw, bool)>);

impl Laws {
    fn of(mechanism: &Mechanism) -> Self {
        let limits = mechanism
            .joints
            .iter()
            .filter_map(|joint| Some((ContactLaw { normal: joint.limit?, friction: None }, joint_words(joint.kind).0)));
        let mut all: Vec<(ContactLaw, bool)> = Vec::new();
        for law in mechanism.contacts.iter().map(|contact| (contact.law, true)).chain(limits) {
            if !all.contains(&law) {
                all.push(law);
            }
        }
        Self(all)
    }

    fn name(&self, law: &ContactLaw, linear: bool) -> String {
        let index = self.0.iter().position(|other| *other == (*law, linear)).unwrap_or(0);
        format!("law_{}", index + 1)
    }

    fn settings(&self) -> Vec<(String, Table)> {
        let settings = |(law, linear): &(ContactLaw, bool)| {
            let NormalLaw { stiffness_n_per_m_e, exponent, damping } = law.normal;
            let pick = |[angular, of_length]: [Dimension; 2]| if *linear { of_length } else { angular };
            let mut settings = table([("stiffness", stiffness_n_per_m_e.into()), ("exponent", exponent.into())]);
            let texts = match damping {
                Damping::HuntCrossley { factor_s_per_m } => {
                    let units = pick([Dimension::AngularImpactDamping, Dimension::LinearImpactDamping]);
                    vec![("type", "hunt_crossley".to_owned()), ("damping", format(factor_s_per_m, units))]
                }
                Damping::Constant { n_s_per_m } => vec![
                    ("type", "spring_damper".to_owned()),
                    ("damping", format(n_s_per_m, pick([Dimension::AngularDamping, Dimension::LinearDamping]))),
                ],
                Damping::Step { max_n_s_per_m, transition_m } => vec![
                    ("type", "step".to_owned()),
                    ("damping", format(max_n_s_per_m, pick([Dimension::AngularDamping, Dimension::LinearDamping]))),
                    ("transition", format(transition_m, pick([Dimension::Angle, Dimension::Length]))),
                ],
            };
            settings.extend(texts.into_iter().map(|(key, text)| (key.to_owned(), text.into())));
            if let Some(Value::Table(friction)) =
                law::contact_settings(law).remove("friction").filter(|_| law.friction.is_some())
            {
                settings.insert("friction".into(), friction.into());
            }
            (self.name(law, *linear), settings)
        };
        self.0.iter().map(settings).collect()
    }
}
