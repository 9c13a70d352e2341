//! Discs without a finger.

use super::super::System;
use super::super::table::disc::DiscKeys;
use super::super::table::half_plane::Ground;
use super::super::table::top::{BodiesKeys, Heading};
use super::super::table::{show as show_table, show_keys};
use super::out::Out;
use super::parts::contact;

pub fn system(out: &mut Out, heading: Heading, system: &System) {
    show_keys(out, &BodiesKeys { heading }, |_| true);
    for disc in &system.discs {
        show_table(out, &format!("discs.{}", disc.name), &DiscKeys::of(disc));
    }
    if let Some(ground) = system.palm {
        show_table(out, "half_plane", &Ground { level_m: ground.level_m });
    }
    system.between_discs.iter().for_each(|law| contact(out, "contact", law));
}
