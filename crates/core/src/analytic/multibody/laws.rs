//! Laws of one contact.

use crate::analytic::ContactState;
use crate::law::{FrictionLaw, NormalLaw};

/// Laws of one contact, and the branch that is active.
#[derive(Clone, Copy)]
pub struct ContactLaws<'a> {
    pub normal: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub state: ContactState,
}
