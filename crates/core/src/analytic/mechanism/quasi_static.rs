//! Stiff contacts and limits that oscillate about their equilibrium depth: the state with them at rest there.

use super::contacts::Surfaces;
use super::model::{MechanismMode, MechanismModel};
use crate::analytic::ContactState;
use crate::analytic::contact::{
    DIFFERENCE_STEP_S, Row, Settling, StateRef, max_chatter_rate, may_chatter, row_dot, settling,
};
use crate::integrator::{Dynamic, QuasiStaticState, Rates, System, Tolerances};

impl MechanismModel {
    /// The state with all oscillating contacts at rest at their equilibrium depths; `None` if there are none.
    pub(super) fn settled(
        &self,
        t: f64,
        (q, v): StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        tolerances: &Tolerances,
    ) -> Option<QuasiStaticState<Dynamic>> {
        let max_rate = max_chatter_rate(tolerances);
        let mut settled = QuasiStaticState { q: q.clone(), v: v.clone(), decay_rate: f64::INFINITY };
        for (index, contact) in self.contacts.iter().enumerate() {
            if matches!(contact.surfaces, Surfaces::Point(_) | Surfaces::Limit(_)) {
                self.settle_contact(t, mode, (index, max_rate), &mut settled);
            }
        }
        settled.decay_rate.is_finite().then_some(settled)
    }

    /// Brings one contact to rest at its equilibrium depth, if it oscillates about it.
    fn settle_contact(
        &self,
        t: f64,
        mode: &MechanismMode,
        (index, max_rate): (usize, f64),
        settled: &mut QuasiStaticState<Dynamic>,
    ) -> Option<()> {
        let QuasiStaticState { q, v, decay_rate } = settled;
        let motion_at = |q: &Vec<f64>, row: &mut [f64]| {
            self.with_columns((q, v), |motions| {
                let contact = self.contact_variables(motions, v, index, mode.features[index]);
                contact.normal_row.write(row);
                [contact.delta, contact.rate]
            })
        };
        let (law, mut row) = (&self.contacts[index].normal, vec![0.0; v.len()]);
        let motion = motion_at(q, &mut row);
        if !may_chatter(law, motion, max_rate) {
            return None;
        }
        let mut without_contact = mode.clone();
        without_contact.contacts[index] = ContactState::Free;
        let mut free = Rates::zero(self.layout());
        self.rates(t, q, v, &without_contact, &mut free);
        // The row changes along the free motion; its contribution to the gap's acceleration is a central difference.
        let gap_rate_after = |h: f64| {
            let moved: Vec<f64> = q.iter().zip(&*v).map(|(q, v)| q + h * v).collect();
            -motion_at(&moved, &mut vec![0.0; v.len()])[1]
        };
        let row_change =
            (gap_rate_after(DIFFERENCE_STEP_S) - gap_rate_after(-DIFFERENCE_STEP_S)) / (2.0 * DIFFERENCE_STEP_S);
        let mut response = row.clone();
        self.with_factors((q, v), |_, factors| self.solve(factors, &mut response));
        let (free_acceleration, mobility) = (row_dot(&row, &free.a) + row_change, row_dot(&row, &response));
        let Settling { of_depth, of_rate, decay_rate: of_contact } =
            settling(law, motion, free_acceleration, mobility)?;
        q.iter_mut().zip(&response).for_each(|(q, part)| *q += of_depth * part);
        v.iter_mut().zip(&response).for_each(|(v, part)| *v += of_rate * part);
        *decay_rate = decay_rate.min(of_contact);
        Some(())
    }
}
