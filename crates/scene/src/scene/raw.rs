//! The file of a finger's scene as it is written.

use super::entry::Section;
use super::sections::sections;
use super::table::bounds::FingerBounds;
use super::table::drive::{Motor, Springs};
use super::table::finger::{Bodies, Material, Object, Start};
use super::table::keys::Keys;
use super::table::law::{Contact, Limit};
use super::table::top::FingerKeys;
use super::{Engine, Integrator, LogRates};
use crate::gripper::{Design, Lengths};

sections! {
    "scene of a finger", RawScene: FingerKeys {
        design: Keys<Design>,
        lengths: Keys<Lengths>,
        material: Keys<Material>,
        bodies: Keys<Bodies>,
        object: Keys<Object>,
        motor: Keys<Motor>,
        spring: Keys<Springs>,
        limit: Keys<Limit>,
        contact: Keys<Contact>,
        initial: Keys<Start>,
        integrator: Keys<Integrator>,
        engine: Keys<Engine>,
        validate: Keys<FingerBounds>,
        log: Keys<LogRates>,
    }
}
