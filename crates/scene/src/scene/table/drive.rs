//! `[motor]` and `[spring]` of a finger; in a gripper the motor also has inertia, a no-load speed and a brake.

use super::{settings, variant_field};
use crate::law::Bristle;
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::keywords::TWO_FINGERS;
use crate::scene::value_kinds::{
    Angle, AngularDamping, AngularRate, AngularStiffness, Choice, Inertia, Keyword, List, Time, Torque,
};
use crate::scene::{self, Actuation, Brake, Interpolation, Placement, Spring, SpringKind};

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

/// Motor torque over time, with times and torques of a table as separate lists.
#[derive(Clone, Debug)]
pub struct MotorSettings {
    pub actuation: Actuation,
    times_s: Vec<f64>,
    torques_n_m: Vec<f64>,
}

impl MotorSettings {
    pub fn from_actuation(actuation: &Actuation) -> Self {
        let (times_s, torques_n_m) = match actuation {
            Actuation::Table { points, .. } => points.iter().copied().unzip(),
            _ => Default::default(),
        };
        MotorSettings { actuation: actuation.clone(), times_s, torques_n_m }
    }

    /// Returns the full torque; `None` for a table.
    pub fn torque_n_m(&mut self) -> Option<&mut f64> {
        match &mut self.actuation {
            Actuation::Constant { torque_n_m }
            | Actuation::Ramp { torque_n_m, .. }
            | Actuation::HalfSine { torque_n_m, .. }
            | Actuation::Reversal { torque_n_m, .. } => Some(torque_n_m),
            Actuation::Table { .. } => None,
        }
    }

    fn is_table(&self) -> bool {
        matches!(self.actuation, Actuation::Table { .. })
    }
}

settings! {
    /// Motor torque on the driven link; counter-clockwise (closing) is positive.
    MotorSettings = Self::from_actuation(&Actuation::Constant { torque_n_m: UNSET }), m;
    /// Torque over time: "constant"; "ramp": rises smoothly during `rise`; "half-sine": one pulse; "reversal": changes
    /// sign at `reverse_at`; "table": `times` and `torques`.
    "profile": Choice<Actuation> = Some(&mut m.actuation);
    /// Full torque. Required, except with profile = "table" or `sizing`.
    "torque": Torque = m.torque_n_m(), depends_on("profile", "with profile = \"table\"");
    /// Duration of the smooth rise from 0 (profile = "ramp").
    "rise": Time = variant_field!(m.actuation, Actuation::Ramp, rise_s), allowed(POSITIVE),
        depends_on("profile", "without profile = \"ramp\""), required("add the duration of the rise: rise = \"2 ms\"");
    /// Duration of the pulse; the torque is 0 after it (profile = "half-sine").
    "pulse": Time = variant_field!(m.actuation, Actuation::HalfSine, length_s), allowed(POSITIVE),
        depends_on("profile", "without profile = \"half-sine\""), required("add the duration of the pulse: pulse = \"10 ms\"");
    /// Time at which the torque changes sign (profile = "reversal").
    "reverse_at": Time = variant_field!(m.actuation, Actuation::Reversal, at_s), allowed(NOT_NEGATIVE),
        depends_on("profile", "without profile = \"reversal\""),
        required("add the time at which the torque changes sign: reverse_at = \"10 ms\"");
    /// Times of the table, increasing; the torque is constant before the first and after the last (profile = "table").
    "times": List<Time> = m.is_table().then_some(&mut m.times_s), depends_on("profile", "without profile = \"table\"");
    /// Torques of the table, one per time (profile = "table").
    "torques": List<Torque> = m.is_table().then_some(&mut m.torques_n_m),
        depends_on("profile", "without profile = \"table\"");
    /// Interpolation between the times of the table: "linear", or "step": each torque is constant until the next time.
    "interpolation": Choice<Interpolation> = variant_field!(m.actuation, Actuation::Table, interpolation),
        depends_on("profile", "without profile = \"table\"");
}

/// Further settings of the motor of a gripper: inertia, no-load speed and brake.
#[derive(Clone, Copy, Debug)]
pub struct ShaftSettings {
    pub inertia_kg_m2: f64,
    /// No-load speed, infinite by default; `None` for a motor without this setting.
    pub no_load_speed_rad_s: Option<f64>,
    pub brake: Option<Brake>,
    /// Release time of the brake, infinite by default; `None` without a brake.
    brake_release_s: Option<f64>,
}

impl ShaftSettings {
    /// Settings of a motor with another inertia.
    pub fn from_motor(motor: &scene::Motor, inertia_kg_m2: f64) -> Self {
        let scene::Motor { no_load_speed_rad_s, brake, .. } = *motor;
        let brake_release_s = brake.and_then(|brake| brake.release_s);
        ShaftSettings { inertia_kg_m2, no_load_speed_rad_s, brake, brake_release_s }
    }

    /// Creates the motor with this torque.
    pub fn into_motor(self, actuation: Actuation) -> scene::Motor {
        let release_s = self.release_s();
        scene::Motor {
            actuation,
            inertia_kg_m2: self.inertia_kg_m2,
            no_load_speed_rad_s: self.no_load_speed_rad_s.filter(|speed| speed.is_finite()),
            brake: self.brake.map(|brake| Brake { release_s, ..brake }),
        }
    }

    /// Time at which the brake is released; `None` if it is never released.
    pub fn release_s(&self) -> Option<f64> {
        self.brake.and(self.brake_release_s).filter(|time| time.is_finite())
    }

    /// Sets the law of the brake; the default bristle has a stiffness of 1e4 N·m/rad, more than a real shaft.
    fn set_brake_law(&mut self, law: Option<Bristle>) {
        if let Some(brake) = &mut self.brake {
            brake.bristle = law.map(|_| Bristle { damping_n_s_per_m: 2.0, relaxation_s: 2e-4 });
        }
    }

    fn bristle(&mut self) -> Option<&mut Bristle> {
        self.brake.as_mut()?.bristle.as_mut()
    }

    fn release_field(&mut self) -> Option<&mut f64> {
        self.brake.is_some().then_some(self.brake_release_s.as_mut()).flatten()
    }
}

impl Keyword for Option<Brake> {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("none", None),
        ("two-way", Some(DEFAULT_BRAKE)),
        ("one-way", Some(Brake { one_way: true, ..DEFAULT_BRAKE })),
    ];

    fn keyword(&self) -> &'static str {
        self.map_or("none", |brake| if brake.one_way { "one-way" } else { "two-way" })
    }
}

const DEFAULT_BRAKE: Brake = Brake {
    torque_n_m: UNSET,
    start_s: UNSET,
    rise_s: 1e-3,
    release_s: None,
    one_way: false,
    v_static_rad_s: 0.01,
    bristle: None,
};

settings! {
    /// Inertia, no-load speed and brake of a motor.
    ShaftSettings = Self {
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: Some(f64::INFINITY),
        brake: None,
        brake_release_s: Some(f64::INFINITY),
    }, s;
    /// Inertia of rotor and gear, reflected to the driven link.
    "inertia": Inertia = Some(&mut s.inertia_kg_m2), allowed(NOT_NEGATIVE), default_text("0 kg*m^2"), only_in(TWO_FINGERS);
    /// Rate of the driven link at which the torque is 0; the torque decreases linearly with the rate. Default: constant
    /// torque.
    "no_load_speed": AngularRate = s.no_load_speed_rad_s.as_mut(), allowed(POSITIVE), only_in(TWO_FINGERS);
    /// Brake: "two-way"; "one-way": blocks opening only; "none".
    "brake": Choice<Option<Brake>> = Some(&mut s.brake), only_in(TWO_FINGERS);
    /// Maximum torque of the brake; beyond it the brake slips.
    "brake_torque": Torque = s.brake.as_mut().map(|brake| &mut brake.torque_n_m), allowed(POSITIVE),
        depends_on("brake", "with brake = \"none\""), required("add the maximum torque: brake_torque = \"2 N*m\""), only_in(TWO_FINGERS);
    /// Time at which the brake begins to engage.
    "brake_at": Time = s.brake.as_mut().map(|brake| &mut brake.start_s), allowed(NOT_NEGATIVE),
        depends_on("brake", "with brake = \"none\""), required("add the time of engagement: brake_at = \"15 ms\""), only_in(TWO_FINGERS);
    /// Duration of engagement and of release.
    "brake_rise": Time = s.brake.as_mut().map(|brake| &mut brake.rise_s), allowed(POSITIVE),
        depends_on("brake", "with brake = \"none\""), only_in(TWO_FINGERS);
    /// Time at which the brake begins to release. Default: never.
    "brake_release": Time = s.release_field(), allowed(POSITIVE), depends_on("brake", "with brake = \"none\""), only_in(TWO_FINGERS);
    /// Half width of the sticking range: the rate at which the brake reaches its maximum torque.
    "brake_v_static": AngularRate = s.brake.as_mut().map(|brake| &mut brake.v_static_rad_s), allowed(POSITIVE),
        depends_on("brake", "with brake = \"none\""), only_in(TWO_FINGERS);
    /// "regularised": creeps within `brake_v_static`; "bristle": holds without creep, by a spring and a damper.
    "brake_law": Choice<Option<Bristle>> = s.brake.as_mut().map(|brake| &mut brake.bristle),
        set_with(|s, law| s.set_brake_law(law)), depends_on("brake", "with brake = \"none\""), only_in(TWO_FINGERS);
    /// Damping of the bristle.
    "brake_damping": AngularDamping = s.bristle().map(|bristle| &mut bristle.damping_n_s_per_m), allowed(POSITIVE),
        depends_on("brake_law", "without brake_law = \"bristle\""), only_in(TWO_FINGERS);
    /// Relaxation time of the bristle: its damping over its stiffness.
    "brake_relaxation": Time = s.bristle().map(|bristle| &mut bristle.relaxation_s), allowed(POSITIVE),
        depends_on("brake_law", "without brake_law = \"bristle\""), only_in(TWO_FINGERS);
}

impl Keyword for Option<SpringKind> {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("constant", Some(SpringKind::Constant { torque_n_m: UNSET })),
        ("torsional", Some(SpringKind::Torsional { stiffness_n_m_per_rad: UNSET, preload_rad: 0.0 })),
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

/// Settings of the spring, which may be absent.
#[derive(Clone, Copy, Debug)]
pub struct SpringSettings {
    pub kind: Option<SpringKind>,
    pub placement: Placement,
}

impl SpringSettings {
    pub fn from_spring(spring: Option<Spring>) -> Self {
        let placement = spring.map_or(Placement::Phalanges, |spring| spring.placement);
        SpringSettings { kind: spring.map(|spring| spring.kind), placement }
    }

    pub fn spring(self) -> Option<Spring> {
        self.kind.map(|kind| Spring { kind, placement: self.placement })
    }
}

/// Access to a field of one kind of spring.
macro_rules! spring_field {
    ($value:expr, $variant:ident, $field:ident) => {
        match &mut $value {
            Some(SpringKind::$variant { $field, .. }) => Some($field),
            _ => None,
        }
    };
}

settings! {
    /// The spring that straightens the finger.
    SpringSettings = Self { kind: Some(SpringKind::Constant { torque_n_m: UNSET }), placement: Placement::Phalanges }, s;
    /// "constant": a constant torque; "torsional": stiffness × (preload + deflection); "none".
    "type": Choice<Option<SpringKind>> = Some(&mut s.kind);
    /// Torque of the constant spring. Required with type = "constant", except with `sizing`.
    "torque": Torque = spring_field!(s.kind, Constant, torque_n_m), allowed(NOT_NEGATIVE),
        depends_on("type", "without type = \"constant\"");
    /// Stiffness of the torsional spring. Required with type = "torsional", except with `sizing`.
    "stiffness": AngularStiffness = spring_field!(s.kind, Torsional, stiffness_n_m_per_rad), allowed(POSITIVE),
        depends_on("type", "without type = \"torsional\"");
    /// Deflection of the torsional spring in the straight configuration.
    "preload": Angle = spring_field!(s.kind, Torsional, preload_rad), allowed(NOT_NEGATIVE),
        depends_on("type", "without type = \"torsional\""), default_text("0 deg");
    /// Joint angle on which the spring acts.
    "placement": Choice<Placement> = s.kind.is_some().then_some(&mut s.placement),
        depends_on("type", "with type = \"none\"");
}
