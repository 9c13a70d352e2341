//! Motor, spring and differential.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::GRIPPER;
use crate::law::Bristle;
use crate::scene::quantity::{
    Angle, AngularDamping, AngularRate, AngularStiffness, Inertia, Keyword, NotNegative, Positive, Quantity, Time,
    Torque, Word, quantities,
};
use crate::scene::{Actuation, Brake, Interpolation, Motor, Placement, Spring, SpringKind};

/// A value that other keys give.
const UNSET: f64 = f64::NAN;

impl Keyword for Actuation {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("constant", Actuation::Constant { torque_n_m: UNSET }),
        ("ramp", Actuation::Ramp { torque_n_m: UNSET, rise_s: UNSET }),
        ("half-sine", Actuation::HalfSine { torque_n_m: UNSET, length_s: UNSET }),
        ("reversal", Actuation::Reversal { torque_n_m: UNSET, at_s: UNSET }),
        ("table", Actuation::Table { points: Vec::new(), interpolation: Interpolation::Linear }),
    ];
}

impl Keyword for Interpolation {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("linear", Interpolation::Linear), ("step", Interpolation::Step)];
}

/// Motor torque on the driven link; counter-clockwise (closing) is positive.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct MotorSettings {
    /// Torque over time: "constant"; "ramp": rises smoothly during `rise`; "half-sine": one pulse; "reversal": changes
    /// sign at `reverse_at`; "table": `times` and `torques`.
    #[schemars(extend("default" = "constant"))]
    pub profile: Word<Actuation>,
    /// Full torque. Required, except with profile = "table" or `sizing`.
    #[schemars(extend("x-with" = "profile = constant|ramp|half-sine|reversal"))]
    pub torque: Option<Quantity<Torque>>,
    /// Duration of the smooth rise from 0 (profile = "ramp").
    #[schemars(extend("x-with" = "profile = ramp", "x-required" = "add the duration of the rise: rise = \"2 ms\""))]
    pub rise: Option<Positive<Time>>,
    /// Duration of the pulse; the torque is 0 after it (profile = "half-sine").
    #[schemars(extend("x-with" = "profile = half-sine", "x-required" = "add the duration of the pulse: pulse = \"10 ms\""))]
    pub pulse: Option<Positive<Time>>,
    /// Time at which the torque changes sign (profile = "reversal").
    #[schemars(extend("x-with" = "profile = reversal",
        "x-required" = "add the time at which the torque changes sign: reverse_at = \"10 ms\""))]
    pub reverse_at: Option<NotNegative<Time>>,
    /// Times of the table, increasing; the torque is constant before the first and after the last (profile = "table").
    #[schemars(extend("x-with" = "profile = table"))]
    pub times: Option<Vec<Quantity<Time>>>,
    /// Torques of the table, one per time (profile = "table").
    #[schemars(extend("x-with" = "profile = table"))]
    pub torques: Option<Vec<Quantity<Torque>>>,
    /// Interpolation between the times of the table: "linear", or "step": each torque is constant until the next time.
    #[schemars(extend("x-with" = "profile = table", "default" = "linear"))]
    pub interpolation: Word<Interpolation>,
    /// Inertia of rotor and gear, reflected to the driven link.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 kg*m^2"))]
    pub inertia: Option<NotNegative<Inertia>>,
    /// Rate of the driven link at which the torque is 0; the torque decreases linearly with the rate. Default: constant
    /// torque.
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub no_load_speed: Option<Positive<AngularRate>>,
    /// Brake: "two-way"; "one-way": blocks opening only; "none".
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "none"))]
    pub brake: Option<Word<Option<Brake>>>,
    /// Maximum torque of the brake; beyond it the brake slips.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way",
        "x-required" = "add the maximum torque: brake_torque = \"2 N*m\""))]
    pub brake_torque: Option<Positive<Torque>>,
    /// Time at which the brake begins to engage.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way",
        "x-required" = "add the time of engagement: brake_at = \"15 ms\""))]
    pub brake_at: Option<NotNegative<Time>>,
    /// Duration of engagement and of release.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "1 ms"))]
    pub brake_rise: Option<Positive<Time>>,
    /// Time at which the brake begins to release. Default: never.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way"))]
    pub brake_release: Option<Positive<Time>>,
    /// Half width of the sticking range: the rate at which the brake reaches its maximum torque.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "0.01 rad/s"))]
    pub brake_v_static: Option<Positive<AngularRate>>,
    /// "regularised": creeps within `brake_v_static`; "bristle": holds without creep, by a spring and a damper.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake = two-way|one-way", "default" = "regularised"))]
    pub brake_law: Option<Word<Option<Bristle>>>,
    /// Damping of the bristle. With its default and that of `brake_relaxation`, the stiffness is 1e4 N·m/rad, more than
    /// that of a real shaft.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake_law = bristle", "default" = "2 N*m*s/rad"))]
    pub brake_damping: Option<Positive<AngularDamping>>,
    /// Relaxation time of the bristle: its damping over its stiffness.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "brake_law = bristle", "default" = "0.2 ms"))]
    pub brake_relaxation: Option<Positive<Time>>,
}

impl MotorSettings {
    /// The torque over time, except that of a table; `None` if a value is missing.
    pub fn actuation(&self, torque_n_m: f64) -> Option<Actuation> {
        Some(match &self.profile.0 {
            Actuation::Ramp { .. } => Actuation::Ramp { torque_n_m, rise_s: *self.rise? },
            Actuation::HalfSine { .. } => Actuation::HalfSine { torque_n_m, length_s: *self.pulse? },
            Actuation::Reversal { .. } => Actuation::Reversal { torque_n_m, at_s: *self.reverse_at? },
            Actuation::Constant { .. } | Actuation::Table { .. } => Actuation::Constant { torque_n_m },
        })
    }

    /// The motor with this torque; `None` if a value is missing.
    pub fn motor(&self, actuation: Actuation) -> Option<Motor> {
        let brake = match self.brake.and_then(|brake| brake.0) {
            None => None,
            Some(Brake { one_way, .. }) => Some(Brake {
                torque_n_m: *self.brake_torque?,
                start_s: *self.brake_at?,
                rise_s: *self.brake_rise?,
                release_s: self.brake_release.map(|release| *release),
                one_way,
                v_static_rad_s: *self.brake_v_static?,
                bristle: match self.brake_law?.0 {
                    None => None,
                    Some(_) => {
                        Some(Bristle { damping_n_s_per_m: *self.brake_damping?, relaxation_s: *self.brake_relaxation? })
                    }
                },
            }),
        };
        let no_load_speed_rad_s = self.no_load_speed.map(|speed| *speed);
        Some(Motor {
            actuation,
            inertia_kg_m2: self.inertia.map_or(0.0, |inertia| *inertia),
            no_load_speed_rad_s,
            brake,
        })
    }

    /// Settings of a motor, with another inertia.
    pub fn from_motor(motor: &Motor, inertia_kg_m2: f64) -> Self {
        let brake = motor.brake;
        let bristle = brake.and_then(|brake| brake.bristle);
        let mut settings = MotorSettings {
            profile: Word(motor.actuation.clone()),
            inertia: Some(inertia_kg_m2.into()),
            no_load_speed: motor.no_load_speed_rad_s.map(Quantity::from),
            brake: Some(Word(brake)),
            brake_torque: brake.map(|brake| brake.torque_n_m.into()),
            brake_at: brake.map(|brake| brake.start_s.into()),
            brake_rise: brake.map(|brake| brake.rise_s.into()),
            brake_release: brake.and_then(|brake| brake.release_s).map(Quantity::from),
            brake_v_static: brake.map(|brake| brake.v_static_rad_s.into()),
            brake_law: brake.map(|brake| Word(brake.bristle)),
            brake_damping: bristle.map(|bristle| bristle.damping_n_s_per_m.into()),
            brake_relaxation: bristle.map(|bristle| bristle.relaxation_s.into()),
            ..MotorSettings::default()
        };
        match &motor.actuation {
            Actuation::Table { points, interpolation } => {
                settings.times = Some(quantities(points.iter().map(|point| point.0)));
                settings.torques = Some(quantities(points.iter().map(|point| point.1)));
                settings.interpolation = Word(*interpolation);
            }
            Actuation::Constant { torque_n_m }
            | Actuation::Ramp { torque_n_m, .. }
            | Actuation::HalfSine { torque_n_m, .. }
            | Actuation::Reversal { torque_n_m, .. } => settings.torque = Some((*torque_n_m).into()),
        }
        match motor.actuation {
            Actuation::Ramp { rise_s, .. } => settings.rise = Some(rise_s.into()),
            Actuation::HalfSine { length_s, .. } => settings.pulse = Some(length_s.into()),
            Actuation::Reversal { at_s, .. } => settings.reverse_at = Some(at_s.into()),
            Actuation::Constant { .. } | Actuation::Table { .. } => {}
        }
        settings
    }
}

const BRAKE: Brake = Brake {
    torque_n_m: UNSET,
    start_s: UNSET,
    rise_s: UNSET,
    release_s: None,
    one_way: false,
    v_static_rad_s: UNSET,
    bristle: None,
};

impl Keyword for Option<Brake> {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("none", None), ("two-way", Some(BRAKE)), ("one-way", Some(Brake { one_way: true, ..BRAKE }))];

    fn keyword(&self) -> &'static str {
        self.map_or("none", |brake| if brake.one_way { "one-way" } else { "two-way" })
    }
}

impl Keyword for Option<SpringKind> {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("constant", Some(SpringKind::Constant { torque_n_m: UNSET })),
        ("torsional", Some(SpringKind::Torsional { stiffness_n_m_per_rad: UNSET, preload_rad: UNSET })),
        ("none", None),
    ];

    fn keyword(&self) -> &'static str {
        match self {
            Some(SpringKind::Constant { .. }) => "constant",
            Some(SpringKind::Torsional { .. }) => "torsional",
            None => "none",
        }
    }
}

impl Keyword for Placement {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        (Placement::Phalanges.name(), Placement::Phalanges),
        (Placement::DrivenCoupler.name(), Placement::DrivenCoupler),
        (Placement::GroundLinks.name(), Placement::GroundLinks),
        (Placement::CouplerDistal.name(), Placement::CouplerDistal),
    ];
}

/// The spring that straightens the finger.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SpringSettings {
    /// "constant": a constant torque; "torsional": stiffness × (preload + deflection); "none".
    #[schemars(extend("default" = "constant"))]
    pub r#type: Word<Option<SpringKind>>,
    /// Torque of the constant spring. Required with type = "constant", except with `sizing`.
    #[schemars(extend("x-with" = "type = constant"))]
    pub torque: Option<NotNegative<Torque>>,
    /// Stiffness of the torsional spring. Required with type = "torsional", except with `sizing`.
    #[schemars(extend("x-with" = "type = torsional"))]
    pub stiffness: Option<Positive<AngularStiffness>>,
    /// Deflection of the torsional spring in the straight configuration.
    #[schemars(extend("x-with" = "type = torsional", "default" = "0 deg"))]
    pub preload: NotNegative<Angle>,
    /// Joint angle on which the spring acts.
    #[schemars(extend("x-with" = "type = constant|torsional", "default" = "q22"))]
    pub placement: Word<Placement>,
}

impl From<Option<Spring>> for SpringSettings {
    fn from(spring: Option<Spring>) -> Self {
        let (kind, placement) = (spring.map(|spring| spring.kind), spring.map(|spring| spring.placement));
        let (torque, stiffness, preload) = match kind {
            Some(SpringKind::Constant { torque_n_m }) => (Some(torque_n_m.into()), None, 0.0),
            Some(SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad }) => {
                (None, Some(stiffness_n_m_per_rad.into()), preload_rad)
            }
            None => (None, None, 0.0),
        };
        let placement = Word(placement.unwrap_or(Placement::Phalanges));
        SpringSettings { r#type: Word(kind), torque, stiffness, preload: preload.into(), placement }
    }
}

/// A differential (seesaw) with [motor] at its input; each finger gets half of the torque. An empty section
/// suffices to add it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct DifferentialSettings {
    /// Whether there is a differential.
    #[schemars(extend("default" = true))]
    pub present: bool,
    /// Inertia of the parts that rotate with the input, by the mean angle of both driven links; added to the inertia of
    /// [motor].
    #[schemars(extend("x-with" = "present = true", "default" = "0 kg*m^2"))]
    pub input_inertia: NotNegative<Inertia>,
    /// Inertia of the seesaw, which rotates by half the difference of the angles of both driven links.
    #[schemars(extend("x-with" = "present = true", "default" = "0 kg*m^2"))]
    pub seesaw_inertia: NotNegative<Inertia>,
}
