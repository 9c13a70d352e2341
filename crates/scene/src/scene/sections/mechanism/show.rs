//! A mechanism as the sections of a scene file. The entry `linear` of a table is no key: it tells whether values whose unit
//! depends on a joint have that of a prismatic one.

use toml::{Table, Value};

use super::contact::LawType;
use super::joint::joint_words;
use super::outline::outline_settings;
use super::tendon::tendon_settings;
use crate::drive::Brake;
use crate::law::{ContactLaw, Damping, NormalLaw};
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
        let given = |value: f64| Some(value).filter(|value| *value != 0.0);
        let bristle = joint.friction.and_then(|law| law.bristle);
        let mut settings = table([
            ("linear", linear.into()),
            ("type", if linear { "prismatic" } else { "revolute" }.into()),
            ("bodies", joint.bodies.iter().map(body_name).collect::<Vec<_>>().into()),
            ("points", joint.points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
            ("offset", joint.offset_rad.into()),
            ("start", option(joint.start)),
            ("start_rate", option(given(joint.start_rate).or(joint.start.and(Some(0.0))))),
            ("damping", option(given(joint.damping))),
            ("armature", option(given(joint.armature))),
            ("friction", option(joint.friction.map(|law| law.mu_dynamic))),
            ("static_friction", option(joint.friction.map(|law| law.mu_static))),
            ("friction_rates", list(joint.friction.iter().flat_map(|law| [law.v_static_m_s, law.v_dynamic_m_s]))),
            ("friction_stiffness", option(bristle.map(|of| of.damping_n_s_per_m / of.relaxation_s))),
            ("lower", option(joint.lower)),
            ("upper", option(joint.upper)),
        ]);
        if let JointKind::Prismatic { axis_rad } = joint.kind {
            settings.insert("axis".into(), axis_rad.into());
        }
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
        let mut settings = match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                let mut settings = combination_settings(on, mechanism);
                settings.extend(table([("type", "torsional".into()), ("torque", (*preload).into())]));
                settings
            }
            SpringKind::Linear { bodies, points_m } => table([
                ("linear", true.into()),
                ("type", "linear".into()),
                ("bodies", bodies.iter().map(body_name).collect::<Vec<_>>().into()),
                ("points", points_m.iter().map(|point| list(*point)).collect::<Vec<_>>().into()),
            ]),
        };
        settings.extend(table([
            ("stiffness", spring.stiffness.into()),
            ("damping", spring.damping.into()),
            ("rest", spring.rest.into()),
        ]));
        (spring.name.clone(), settings)
    };
    let coupling = |coupling: &Coupling| {
        let mut settings = joints_settings(&coupling.on, mechanism);
        settings.insert("value".into(), coupling.on.offset.into());
        (coupling.name.clone(), settings)
    };
    let rotor = |rotor: &Rotor| {
        let mut settings = joints_settings(&rotor.on, mechanism);
        settings.insert("inertia".into(), rotor.inertia.into());
        (rotor.name.clone(), settings)
    };
    let actuators = mechanism.actuators.iter().map(|each| actuator_settings(each, mechanism));
    let pulls = mechanism.tendons.iter().filter_map(|tendon| {
        let TendonActuator { name, tension } = tendon.actuator.as_ref()?;
        let mut settings = table([("tendon", tendon.name.as_str().into())]);
        insert_profile(&mut settings, tension, "tension");
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
            ("rolling_arm", option(contact.rolling.map(|law| law.mu_static))),
            ("rolling_rate", option(contact.rolling.map(|law| law.v_static_m_s))),
        ]))
    };
    file.insert("contacts".into(), mechanism.contacts.iter().map(contact).collect::<Vec<_>>().into());
    file
}

/// A value that may be missing.
fn option(value: Option<f64>) -> Value {
    value.unwrap_or(f64::NAN).into()
}

fn actuator_settings(actuator: &Actuator, mechanism: &Mechanism) -> (String, Table) {
    let mut settings = combination_settings(&actuator.on, mechanism);
    let linear = settings["linear"].clone();
    match &actuator.command {
        Command::Effort(profile) => {
            let key = if linear.as_bool() == Some(true) { "force" } else { "torque" };
            insert_profile(&mut settings, profile, key);
        }
        Command::Servo { kp, kd, target, target_rate, rate_hz } => {
            insert_profile(&mut settings, target, "target");
            settings.extend(table([
                ("kp", (*kp).into()),
                ("kd", (*kd).into()),
                ("target_rate", option(*target_rate)),
                ("rate", option(*rate_hz)),
            ]));
        }
    }
    settings.extend(table([("limit", option(actuator.limit)), ("no_load_speed", option(actuator.no_load_speed))]));
    if let Some(brake) = actuator.brake {
        let Brake { torque_n_m, start_s, rise_s, release_s, one_way, v_static_rad_s, bristle } = brake;
        let brake = table([
            ("linear", linear),
            ("limit", torque_n_m.into()),
            ("at", start_s.into()),
            ("rise", rise_s.into()),
            ("release", option(release_s)),
            ("one_way", one_way.into()),
            ("rate", v_static_rad_s.into()),
            ("stiffness", option(bristle.map(|bristle| bristle.damping_n_s_per_m / bristle.relaxation_s))),
            ("relaxation", option(bristle.map(|bristle| bristle.relaxation_s))),
        ]);
        settings.insert("brake".into(), brake.into());
    }
    (actuator.name.clone(), settings)
}

/// Settings of the joints and factors of a combination.
fn joints_settings(on: &JointCombination, mechanism: &Mechanism) -> Table {
    let name = |(joint, _): &(usize, f64)| Value::from(mechanism.joints[*joint].name.as_str());
    let linear = on.terms.first().is_some_and(|(joint, _)| joint_words(mechanism.joints[*joint].kind).0);
    table([
        ("linear", linear.into()),
        ("joints", on.terms.iter().map(name).collect::<Vec<_>>().into()),
        ("factors", list(on.terms.iter().map(|(_, factor)| *factor))),
    ])
}

/// The same for a spring or an actuator, which name a single joint by itself.
fn combination_settings(on: &JointCombination, mechanism: &Mechanism) -> Table {
    let mut settings = joints_settings(on, mechanism);
    if let Some(joint) = on.joint() {
        let joint = mechanism.joints[joint].name.as_str().into();
        return table([("linear", settings["linear"].clone()), ("joint", joint)]);
    }
    settings.insert("offset".into(), on.offset.into());
    settings
}

/// Inserts a constant, or times and values.
fn insert_profile(settings: &mut Table, profile: &Profile, key: &str) {
    match profile {
        Profile::Table { points, .. } => {
            settings.insert("times".into(), list(points.iter().map(|point| point.0)));
            settings.insert(format!("{key}s"), list(points.iter().map(|point| point.1)));
        }
        other => _ = settings.insert(key.into(), other.at(0.0).0.into()),
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
            // The unit of the damping also depends on the type.
            let text = |si: f64, angular: Dimension, of_length: Dimension| -> Value {
                format(si, if *linear { of_length } else { angular }).into()
            };
            let (law_type, damping, transition_m) = match damping {
                Damping::HuntCrossley { factor_s_per_m } => {
                    let (angular, of_length) = (Dimension::AngularImpactDamping, Dimension::LinearImpactDamping);
                    (LawType::HuntCrossley, text(factor_s_per_m, angular, of_length), None)
                }
                Damping::Constant { n_s_per_m } => {
                    let damping = text(n_s_per_m, Dimension::AngularDamping, Dimension::LinearDamping);
                    (LawType::SpringDamper, damping, None)
                }
                Damping::Step { max_n_s_per_m, transition_m } => {
                    let damping = text(max_n_s_per_m, Dimension::AngularDamping, Dimension::LinearDamping);
                    (LawType::Step, damping, Some(transition_m))
                }
            };
            let mut settings = table([
                ("linear", (*linear).into()),
                ("type", law_type.keyword().into()),
                ("stiffness", stiffness_n_per_m_e.into()),
                ("exponent", exponent.into()),
                ("damping", damping),
                ("transition", option(transition_m)),
            ]);
            if law.friction.is_some() {
                settings.insert("friction".into(), law::friction_settings(law.friction.as_ref()).into());
            }
            (self.name(law, *linear), settings)
        };
        self.0.iter().map(settings).collect()
    }
}
