//! A mechanism as the sections of a scene file. The entry `linear` of a table is no key: it tells whether values whose unit
//! depends on a joint have that of a prismatic one.

use serde_json::{Value, json};

use super::contact::LawType;
use super::joint::{JointType, SpringType};
use super::limit::sum_limit_settings;
use super::outline::outline_settings;
use super::powertrain::{Units, point_settings, powertrain_settings};
use super::tendon::tendon_settings;
use crate::drive::Brake;
use crate::law::{ContactLaw, Damping, FrictionKind, NormalLaw};
use crate::mechanism::{
    Actuator, Body, Command, ContactPair, Coupling, Joint, JointCombination, Mechanism, Rotor, Spring, SpringKind,
    TendonActuator,
};
use crate::scene::quantity::Keyword;
use crate::scene::sections::motion::palm_motion_settings;
use crate::scene::sections::{extend, law};
use crate::scene::{Interpolation, Profile};
use crate::units::{Dimension, format};

/// Settings that describe a mechanism, by section.
pub fn mechanism_settings(mechanism: &Mechanism) -> Value {
    let laws = Laws::of(mechanism);
    let body = |(index, body): (usize, &Body)| {
        let ([x, y, angle], [vx, vy, spin]) = (body.pose, body.rate);
        let mut settings = json!({
            "mass": body.mass_kg,
            "inertia": body.inertia_kg_m2,
            "com": body.com_m,
            "outlines": body.outlines.iter().map(outline_settings).collect::<Value>(),
            "points": point_settings(&body.points),
        });
        if mechanism.has_joint(Some(index)) {
            settings["guess"] = json!({ "at": [x, y], "angle": angle });
        } else {
            settings["start"] = json!({ "at": [x, y], "angle": angle, "velocity": [vx, vy], "spin": spin });
        }
        (body.name.clone(), settings)
    };
    let contact = |contact: &ContactPair| {
        json!({
            "points": mechanism.outline_name(contact.points),
            "face": mechanism.outline_name(contact.face),
            "law": laws.name(&contact.law, true),
            "at": contact.force_point.keyword(),
            "rolling_arm": contact.rolling.map(|law| law.mu_static),
            "rolling_rate": contact.rolling.map(|law| law.v_static_m_s),
        })
    };
    let pulls = mechanism.tendons.iter().filter_map(|tendon| {
        let TendonActuator { name, tension } = tendon.actuator.as_ref()?;
        let mut settings = profile_settings(tension, "tension");
        settings["tendon"] = tendon.name.as_str().into();
        Some((name.clone(), settings))
    });
    let actuators = mechanism.actuators.iter().map(|each| actuator_settings(each, mechanism));
    let joints = mechanism.joints.iter().map(|each| joint_settings(each, mechanism, &laws));
    let springs = mechanism.springs.iter().map(|each| spring_settings(each, mechanism));
    let tendons = mechanism.tendons.iter().map(|each| tendon_settings(each, mechanism));
    let couplings = mechanism.couplings.iter().map(|Coupling { name, on }| {
        let mut settings = joints_settings(on, mechanism);
        settings["value"] = on.offset.into();
        (name.clone(), settings)
    });
    let rotors = mechanism.rotors.iter().map(|Rotor { name, on, inertia }| {
        let mut settings = joints_settings(on, mechanism);
        settings["inertia"] = (*inertia).into();
        (name.clone(), settings)
    });
    let limits = mechanism.sum_limits.iter().map(|limit| {
        let mut settings = joints_settings(&limit.on, mechanism);
        let law = laws.name(&ContactLaw { normal: limit.law, friction: None }, settings["linear"] == true);
        extend(&mut settings, sum_limit_settings(limit, law));
        (limit.name.clone(), settings)
    });
    // The body that stands for the ground has its outlines and points.
    let frame = mechanism.frame();
    let moving_outlines = frame.map_or(&[][..], |frame| &mechanism.bodies[frame].outlines);
    let ground_outlines = mechanism.ground_outlines.iter().chain(moving_outlines);
    let bodies = mechanism.bodies.iter().enumerate().filter(|(index, _)| frame != Some(*index));
    let mut settings = json!({
        "bodies": bodies.map(body).collect::<Value>(),
        "ground": {
            "outlines": ground_outlines.map(outline_settings).collect::<Value>(),
            "points": point_settings(frame.map_or(&mechanism.ground_points, |frame| &mechanism.bodies[frame].points)),
        },
        "joints": joints.collect::<Value>(),
        "springs": springs.collect::<Value>(),
        "tendons": tendons.collect::<Value>(),
        "couplings": couplings.collect::<Value>(),
        "actuators": actuators.chain(pulls).collect::<Value>(),
        "rotors": rotors.collect::<Value>(),
        "limits": limits.collect::<Value>(),
        "laws": laws.settings(),
        "contacts": mechanism.contacts.iter().map(contact).collect::<Value>(),
    });
    if let Some((body, motion)) = mechanism.palm() {
        extend(&mut settings, palm_motion_settings(motion, Some(mechanism.body_name(Some(body)))));
    }
    settings
}

fn joint_settings(joint: &Joint, mechanism: &Mechanism, laws: &Laws) -> (String, Value) {
    let linear = !joint.kind.is_angle();
    let axis_rad = joint.kind.axis_rad();
    let given = |value: f64| Some(value).filter(|value| *value != 0.0);
    let bristle = match joint.friction.map(|law| law.kind) {
        Some(FrictionKind::Bristle(bristle)) => Some(bristle),
        _ => None,
    };
    let limit = joint.limit.filter(|_| joint.lower.or(joint.upper).is_some());
    let settings = json!({
        "linear": linear,
        "type": if linear { JointType::Prismatic } else { JointType::Revolute },
        "axis": axis_rad,
        "bodies": joint.bodies.map(|body| mechanism.body_name(body)),
        "points": joint.points_m,
        "offset": joint.offset_rad,
        "start": joint.start,
        "start_rate": given(joint.start_rate).or(joint.start.and(Some(0.0))),
        "damping": given(joint.damping),
        "armature": given(joint.armature),
        "friction": joint.friction.map(|law| law.mu_dynamic),
        "static_friction": joint.friction.map(|law| law.mu_static),
        "friction_rates": joint.friction.map(|law| [law.v_static_m_s, law.v_dynamic_m_s]),
        "friction_stiffness": bristle.map(|of| of.damping_n_s_per_m / of.relaxation_s),
        "lower": joint.lower,
        "upper": joint.upper,
        "stop": limit.map(|normal| laws.name(&ContactLaw { normal, friction: None }, linear)),
    });
    (joint.name.clone(), settings)
}

fn spring_settings(spring: &Spring, mechanism: &Mechanism) -> (String, Value) {
    let mut settings = match &spring.kind {
        SpringKind::Torsional { on, preload } => {
            let mut settings = combination_settings(on, mechanism);
            extend(&mut settings, json!({ "type": SpringType::Torsional, "torque": preload }));
            settings
        }
        SpringKind::Linear { bodies, points_m } => json!({
            "linear": true,
            "type": SpringType::Linear,
            "bodies": bodies.map(|body| mechanism.body_name(body)),
            "points": points_m,
        }),
    };
    let common = json!({ "stiffness": spring.stiffness, "damping": spring.damping, "rest": spring.rest });
    extend(&mut settings, common);
    (spring.name.clone(), settings)
}

fn actuator_settings(actuator: &Actuator, mechanism: &Mechanism) -> (String, Value) {
    let mut settings = combination_settings(&actuator.on, mechanism);
    let linear = settings["linear"].clone();
    let powertrain = &actuator.powertrain;
    extend(&mut settings, powertrain_settings(actuator, linear == true, mechanism));
    let (is_geared, has_motor) = (!settings["gear"].is_null(), powertrain.motor.is_some());
    let units = Units {
        linear: linear == true,
        of: "",
        shaft_is_linear: linear == true && !is_geared && !has_motor,
        has_motor,
        measures_length: linear == true || powertrain.feedback.is_some(),
    };
    // Units that differ from those of the coordinate.
    let text = |key: &str, value: Option<f64>| -> Value {
        match (units.dimension(key), value) {
            (Some(dimension), Some(value)) => format(value, dimension).into(),
            (_, value) => value.into(),
        }
    };
    let effort = if units.shaft_is_linear { "force" } else { "torque" };
    let command = match &actuator.command {
        Command::Effort(profile) if has_motor => {
            let voltages = profile_settings(profile, "voltage");
            let (times, interpolation) = (voltages["times"].clone(), voltages["interpolation"].clone());
            for key in ["voltage", "voltages"] {
                settings["motor"][key] = voltages[key].clone();
            }
            json!({ "times": times, "interpolation": interpolation })
        }
        Command::Effort(profile) => profile_settings(profile, effort),
        Command::Servo { kp, kd, target, target_rate, rate_hz } => {
            let gains = [("kp", Some(*kp)), ("kd", Some(*kd)), ("target_rate", *target_rate)];
            gains.into_iter().for_each(|(key, value)| settings[key] = text(key, value));
            settings["rate"] = (*rate_hz).into();
            let mut targets = profile_settings(target, "target");
            if units.measures_length != units.linear {
                let in_units = |value: &Value| text("target", value.as_f64());
                for key in ["target", "targets"] {
                    targets[key] = match &targets[key] {
                        Value::Array(values) => values.iter().map(in_units).collect(),
                        value => in_units(value),
                    };
                }
            }
            targets
        }
    };
    extend(&mut settings, command);
    if has_motor {
        // The limit of a controller is the voltage of the supply.
        if let (Command::Servo { .. }, Some(voltage)) = (&actuator.command, actuator.limit) {
            settings["motor"]["voltage"] = voltage.into();
        }
    } else {
        let limits = [("limit", actuator.limit), ("no_load_speed", actuator.no_load_speed)];
        limits.into_iter().for_each(|(key, value)| settings[key] = text(key, value));
    }
    if let Some(brake) = actuator.brake {
        let Brake { torque_n_m, start_s, rise_s, release_s, one_way, v_static_rad_s, bristle } = brake;
        settings["brake"] = json!({
            "linear": linear,
            "limit": torque_n_m,
            "at": start_s,
            "rise": rise_s,
            "release": release_s,
            "one_way": one_way,
            "rate": v_static_rad_s,
            "stiffness": bristle.map(|bristle| bristle.damping_n_s_per_m / bristle.relaxation_s),
            "relaxation": bristle.map(|bristle| bristle.relaxation_s),
        });
    }
    (actuator.name.clone(), settings)
}

/// Settings of the joints and factors of a combination.
fn joints_settings(on: &JointCombination, mechanism: &Mechanism) -> Value {
    let joint = |(joint, _): &(usize, f64)| &mechanism.joints[*joint];
    json!({
        "linear": on.terms.first().is_some_and(|term| !joint(term).kind.is_angle()),
        "joints": on.terms.iter().map(|term| joint(term).name.as_str()).collect::<Value>(),
        "factors": on.terms.iter().map(|(_, factor)| *factor).collect::<Value>(),
    })
}

/// The same for a spring or an actuator, which name a single joint by itself.
fn combination_settings(on: &JointCombination, mechanism: &Mechanism) -> Value {
    let mut settings = joints_settings(on, mechanism);
    match on.joint() {
        Some(joint) => json!({ "linear": settings["linear"], "joint": mechanism.joints[joint].name }),
        None => {
            settings["offset"] = on.offset.into();
            settings
        }
    }
}

/// A value under this key, which may rise or be that of a pulse, or times and values.
fn profile_settings(profile: &Profile, key: &str) -> Value {
    let table = |points: &[(f64, f64)], interpolation: Interpolation| {
        json!({
            "times": points.iter().map(|point| point.0).collect::<Value>(),
            (format!("{key}s")): points.iter().map(|point| point.1).collect::<Value>(),
            "interpolation": interpolation.keyword(),
        })
    };
    match profile {
        Profile::Constant { value } => json!({ key: value }),
        Profile::Ramp { value, rise_s } => json!({ key: value, "rise": rise_s }),
        Profile::HalfSine { value, length_s } => json!({ key: value, "pulse": length_s }),
        // A table has at least one time before the reversal.
        Profile::Reversal { value, at_s } if *at_s > 0.0 => {
            table(&[(0.0, *value), (*at_s, -value)], Interpolation::Step)
        }
        Profile::Reversal { value, .. } => json!({ key: -value }),
        Profile::Table { points, interpolation } => table(points, *interpolation),
    }
}

/// All different laws of a mechanism, which get names by their order, and whether they are those of contacts.
struct Laws(Vec<(ContactLaw, bool)>);

impl Laws {
    fn of(mechanism: &Mechanism) -> Self {
        let limits = mechanism
            .joints
            .iter()
            .filter_map(|joint| Some((ContactLaw { normal: joint.limit?, friction: None }, !joint.kind.is_angle())));
        let mut all: Vec<(ContactLaw, bool)> = Vec::new();
        let sums = mechanism.sum_limits.iter().map(|limit| {
            let linear = limit.on.terms.first().is_some_and(|(joint, _)| !mechanism.joints[*joint].kind.is_angle());
            (ContactLaw { normal: limit.law, friction: None }, linear)
        });
        for law in mechanism.contacts.iter().map(|contact| (contact.law, true)).chain(limits).chain(sums) {
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

    fn settings(&self) -> Value {
        let settings = |(law, linear): &(ContactLaw, bool)| {
            let NormalLaw { stiffness_n_per_m_e, exponent, damping } = law.normal;
            let (law_type, damping, units, transition_m) = match damping {
                Damping::HuntCrossley { factor_s_per_m } => {
                    let units = [Dimension::AngularImpactDamping, Dimension::LinearImpactDamping];
                    (LawType::HuntCrossley, factor_s_per_m, units, None)
                }
                Damping::Constant { n_s_per_m } => {
                    (LawType::SpringDamper, n_s_per_m, [Dimension::AngularDamping, Dimension::LinearDamping], None)
                }
                Damping::Step { max_n_s_per_m, transition_m } => {
                    let units = [Dimension::AngularDamping, Dimension::LinearDamping];
                    (LawType::Step, max_n_s_per_m, units, Some(transition_m))
                }
            };
            let settings = json!({
                "linear": linear,
                "type": law_type,
                "stiffness": stiffness_n_per_m_e,
                "exponent": exponent,
                // Its unit also depends on the type.
                "damping": format(damping, units[usize::from(*linear)]),
                "transition": transition_m,
                "friction": law.friction.map(|friction| law::friction_settings(Some(friction))),
            });
            (self.name(law, *linear), settings)
        };
        self.0.iter().map(settings).collect()
    }
}
