//! What answers in one contact.

use crate::analytic::SiteState;
use crate::law::{FrictionLaw, NormalLaw};

/// Laws of one contact, and the branch they are on.
#[derive(Clone, Copy)]
pub struct Laws<'a> {
    pub normal: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub state: SiteState,
}
