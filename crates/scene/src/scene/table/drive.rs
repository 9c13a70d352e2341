//! `[motor]` and `[spring]` of a finger; with two fingers the motor is one as bought.

use super::{lines, of};
use crate::law::Bristle;
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::{
    Angle, AngularDamping, AngularRate, AngularStiffness, Choice, Inertia, List, Time, Torque, Words,
};
use crate::scene::words::TWO_FINGERS;
use crate::scene::{self, Actuation, Brake, Interpolation, Placement, Spring, SpringKind};

const GIVEN: f64 = f64::NAN;

impl Words for Actuation {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("constant", Actuation::Constant { torque_n_m: GIVEN }),
        ("ramp", Actuation::Ramp { torque_n_m: GIVEN, rise_s: GIVEN }),
        ("half-sine", Actuation::HalfSine { torque_n_m: GIVEN, length_s: GIVEN }),
        ("reversal", Actuation::Reversal { torque_n_m: GIVEN, at_s: GIVEN }),
        ("table", Actuation::Table { points: Vec::new(), interpolation: Interpolation::Linear }),
    ];
}

/// The motor, with the points of a table apart.
#[derive(Clone, Debug)]
pub struct Motor {
    pub actuation: Actuation,
    times_s: Vec<f64>,
    torques_n_m: Vec<f64>,
}

impl Motor {
    pub fn of(actuation: &Actuation) -> Self {
        let (times_s, torques_n_m) = match actuation {
            Actuation::Table { points, .. } => points.iter().copied().unzip(),
            _ => Default::default(),
        };
        Motor { actuation: actuation.clone(), times_s, torques_n_m }
    }

    /// The full torque; a table has none.
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

lines! {
    /// Torque of the motor on the driven link; counter-clockwise (closing) is positive.
    Motor = Self::of(&Actuation::Constant { torque_n_m: GIVEN }), m;
    /// How the torque goes over time: "constant"; "ramp": rises smoothly over `rise`; "half-sine": one pulse;
    /// "reversal": changes sign at `reverse_at`; "table": `times` and `torques`.
    "profile": Choice<Actuation> = Some(&mut m.actuation);
    /// Full torque. Required, except with profile = "table" or `sizing`.
    "torque": Torque = m.torque_n_m(), beside("profile", "with profile = \"table\"");
    /// Time of the smooth rise from 0 (profile = "ramp").
    "rise": Time = of!(m.actuation, Actuation::Ramp, rise_s), allowed(POSITIVE),
        beside("profile", "without profile = \"ramp\""), needed("add the time of the rise: rise = \"2 ms\"");
    /// Length of the pulse, after which the torque is 0 (profile = "half-sine").
    "pulse": Time = of!(m.actuation, Actuation::HalfSine, length_s), allowed(POSITIVE),
        beside("profile", "without profile = \"half-sine\""), needed("add the length of the pulse: pulse = \"10 ms\"");
    /// When the torque changes sign (profile = "reversal").
    "reverse_at": Time = of!(m.actuation, Actuation::Reversal, at_s), allowed(NOT_NEGATIVE),
        beside("profile", "without profile = \"reversal\""),
        needed("add when the torque changes sign: reverse_at = \"10 ms\"");
    /// Times of the table, increasing; the first torque holds before, the last one after (profile = "table").
    "times": List<Time> = m.is_table().then_some(&mut m.times_s), beside("profile", "without profile = \"table\"");
    /// Torques of the table, one for each time (profile = "table").
    "torques": List<Torque> = m.is_table().then_some(&mut m.torques_n_m),
        beside("profile", "without profile = \"table\"");
    /// Between the times of the table: "linear", or "step", where each torque holds until the next time.
    "interpolation": Choice<Interpolation> = of!(m.actuation, Actuation::Table, interpolation),
        beside("profile", "without profile = \"table\"");
}

/// What else a motor as bought has: what turns with it, and what holds it.
#[derive(Clone, Copy, Debug)]
pub struct Shaft {
    pub inertia_kg_m2: f64,
    /// `None` where the motor has no such speed; infinite where nothing is said of it.
    pub no_load_speed_rad_s: Option<f64>,
    pub brake: Option<Brake>,
    /// The same of its brake, which may hold for good.
    brake_release_s: Option<f64>,
}

impl Shaft {
    /// As a scene says it; what turns with it is `inertia_kg_m2`.
    pub fn of(motor: &scene::Motor, inertia_kg_m2: f64) -> Self {
        let scene::Motor { no_load_speed_rad_s, brake, .. } = *motor;
        let brake_release_s = brake.and_then(|brake| brake.release_s);
        Shaft { inertia_kg_m2, no_load_speed_rad_s, brake, brake_release_s }
    }

    /// The motor that has this torque.
    pub fn with(self, actuation: Actuation) -> scene::Motor {
        let release_s = self.release_s();
        scene::Motor {
            actuation,
            inertia_kg_m2: self.inertia_kg_m2,
            no_load_speed_rad_s: self.no_load_speed_rad_s.filter(|speed| speed.is_finite()),
            brake: self.brake.map(|brake| Brake { release_s, ..brake }),
        }
    }

    /// When the brake lets go, if it does.
    pub fn release_s(&self) -> Option<f64> {
        self.brake.and(self.brake_release_s).filter(|time| time.is_finite())
    }

    /// A shaft of 1e4 N·m/rad, stiffer than a real one.
    fn hold_by(&mut self, law: Option<Bristle>) {
        if let Some(brake) = &mut self.brake {
            brake.bristle = law.map(|_| Bristle { damping_n_s_per_m: 2.0, relaxation_s: 2e-4 });
        }
    }

    fn bristle(&mut self) -> Option<&mut Bristle> {
        self.brake.as_mut()?.bristle.as_mut()
    }

    fn release_place(&mut self) -> Option<&mut f64> {
        self.brake.is_some().then_some(self.brake_release_s.as_mut()).flatten()
    }
}

impl Words for Option<Brake> {
    const WORDS: &'static [(&'static str, Self)] =
        &[("none", None), ("two-way", Some(GRIPS)), ("one-way", Some(Brake { one_way: true, ..GRIPS }))];

    fn word(&self) -> &'static str {
        self.map_or("none", |brake| if brake.one_way { "one-way" } else { "two-way" })
    }
}

const GRIPS: Brake = Brake {
    torque_n_m: GIVEN,
    start_s: GIVEN,
    rise_s: 1e-3,
    release_s: None,
    one_way: false,
    v_static_rad_s: 0.01,
    bristle: None,
};

lines! {
    /// A motor as bought.
    Shaft = Self {
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: Some(f64::INFINITY),
        brake: None,
        brake_release_s: Some(f64::INFINITY),
    }, s;
    /// Inertia of rotor and gear, as the driven link feels it.
    "inertia": Inertia = Some(&mut s.inertia_kg_m2), allowed(NOT_NEGATIVE), said("0 kg*m^2"), of(TWO_FINGERS);
    /// Rate of the driven link at which nothing is left of the torque, which falls in proportion. Default: the torque stays.
    "no_load_speed": AngularRate = s.no_load_speed_rad_s.as_mut(), allowed(POSITIVE), of(TWO_FINGERS);
    /// What blocks it: "two-way"; "one-way": against opening only; "none".
    "brake": Choice<Option<Brake>> = Some(&mut s.brake), of(TWO_FINGERS);
    /// Most that the brake holds; beyond it slips.
    "brake_torque": Torque = s.brake.as_mut().map(|brake| &mut brake.torque_n_m), allowed(POSITIVE),
        beside("brake", "with brake = \"none\""), needed("add what it holds: brake_torque = \"2 N*m\""), of(TWO_FINGERS);
    /// When it begins to grip.
    "brake_at": Time = s.brake.as_mut().map(|brake| &mut brake.start_s), allowed(NOT_NEGATIVE),
        beside("brake", "with brake = \"none\""), needed("add when it grips: brake_at = \"15 ms\""), of(TWO_FINGERS);
    /// Time in which it grips, and in which it lets go.
    "brake_rise": Time = s.brake.as_mut().map(|brake| &mut brake.rise_s), allowed(POSITIVE),
        beside("brake", "with brake = \"none\""), of(TWO_FINGERS);
    /// When it begins to let go. Default: never.
    "brake_release": Time = s.release_place(), allowed(POSITIVE), beside("brake", "with brake = \"none\""), of(TWO_FINGERS);
    /// Half width of the range of rates in which it sticks: its torque rises from 0 to all of it up to there.
    "brake_v_static": AngularRate = s.brake.as_mut().map(|brake| &mut brake.v_static_rad_s), allowed(POSITIVE),
        beside("brake", "with brake = \"none\""), of(TWO_FINGERS);
    /// "regularised": creeps within `brake_v_static`; "bristle": holds, like a shaft with a spring and a damper.
    "brake_law": Choice<Option<Bristle>> = s.brake.as_mut().map(|brake| &mut brake.bristle),
        put(|s, law| s.hold_by(law)), beside("brake", "with brake = \"none\""), of(TWO_FINGERS);
    /// Damping of that.
    "brake_damping": AngularDamping = s.bristle().map(|bristle| &mut bristle.damping_n_s_per_m), allowed(POSITIVE),
        beside("brake_law", "without brake_law = \"bristle\""), of(TWO_FINGERS);
    /// Time in which it relaxes: its damping over its stiffness.
    "brake_relaxation": Time = s.bristle().map(|bristle| &mut bristle.relaxation_s), allowed(POSITIVE),
        beside("brake_law", "without brake_law = \"bristle\""), of(TWO_FINGERS);
}

impl Words for Option<SpringKind> {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("constant", Some(SpringKind::Constant { torque_n_m: GIVEN })),
        ("torsional", Some(SpringKind::Torsional { stiffness_n_m_per_rad: GIVEN, preload_rad: 0.0 })),
        ("none", None),
    ];

    fn word(&self) -> &'static str {
        match self {
            Some(SpringKind::Constant { .. }) => "constant",
            Some(SpringKind::Torsional { .. }) => "torsional",
            None => "none",
        }
    }
}

/// The spring, if there is one.
#[derive(Clone, Copy, Debug)]
pub struct Springs {
    pub kind: Option<SpringKind>,
    pub placement: Placement,
}

impl Springs {
    pub fn of(spring: Option<Spring>) -> Self {
        let placement = spring.map_or(Placement::Phalanges, |spring| spring.placement);
        Springs { kind: spring.map(|spring| spring.kind), placement }
    }

    pub fn spring(self) -> Option<Spring> {
        self.kind.map(|kind| Spring { kind, placement: self.placement })
    }
}

/// The place of a number of one kind of spring.
macro_rules! spring {
    ($value:expr, $variant:ident, $field:ident) => {
        match &mut $value {
            Some(SpringKind::$variant { $field, .. }) => Some($field),
            _ => None,
        }
    };
}

lines! {
    /// The spring that pulls the finger straight.
    Springs = Self { kind: Some(SpringKind::Constant { torque_n_m: GIVEN }), placement: Placement::Phalanges }, s;
    /// "constant": a constant torque; "torsional": stiffness × (preload + deflection); "none".
    "type": Choice<Option<SpringKind>> = Some(&mut s.kind);
    /// Torque of the constant spring. Required with type = "constant", except with `sizing`.
    "torque": Torque = spring!(s.kind, Constant, torque_n_m), allowed(NOT_NEGATIVE),
        beside("type", "without type = \"constant\"");
    /// Stiffness of the torsional spring. Required with type = "torsional", except with `sizing`.
    "stiffness": AngularStiffness = spring!(s.kind, Torsional, stiffness_n_m_per_rad), allowed(POSITIVE),
        beside("type", "without type = \"torsional\"");
    /// Deflection of the torsional spring in the straight configuration.
    "preload": Angle = spring!(s.kind, Torsional, preload_rad), allowed(NOT_NEGATIVE),
        beside("type", "without type = \"torsional\""), said("0 deg");
    /// Joint angle the spring acts on.
    "placement": Choice<Placement> = s.kind.is_some().then_some(&mut s.placement),
        beside("type", "with type = \"none\"");
}
