//! Table of all points of grasp-state volumes: one row for each base, friction and design.

use crate::study::volume::{GraspState, Point, Volume};
use crate::table::{Column, Kind, Table, Value};

/// Names and types of the columns. State columns are missing where no finger exists; `reason` is missing where one
/// exists.
const COLUMNS: [(&str, Kind); 20] = [
    ("base_m", Kind::Number),
    ("mu_static", Kind::Number),
    ("l21_fraction", Kind::Number),
    ("phi22_rad", Kind::Number),
    ("arm_ratio", Kind::Number),
    ("l11_m", Kind::Number),
    ("l12_m", Kind::Number),
    ("l21_m", Kind::Number),
    ("l22_m", Kind::Number),
    ("t22_m", Kind::Number),
    ("mass_kg", Kind::Number),
    ("motor_n_m", Kind::Number),
    ("spring_n_m", Kind::Number),
    ("static_f21_n", Kind::Number),
    ("static_f22_n", Kind::Number),
    ("static_pfp_n", Kind::Number),
    ("force_positive", Kind::Flag),
    ("palm_force_positive", Kind::Flag),
    ("form_closed", Kind::Flag),
    ("reason", Kind::Text),
];

/// Returns the table of all points of all volumes, in order.
pub fn volume_points(volumes: &[Volume]) -> Table {
    let columns = COLUMNS.map(|(name, kind)| Column::new(name, kind)).to_vec();
    let rows = volumes.iter().flat_map(|volume| volume.points.iter().map(|point| row(volume, point)));
    Table::new(columns, rows.collect())
}

fn row(volume: &Volume, point: &Point) -> Vec<Value> {
    let Point { l21_fraction, phi22_rad, arm_ratio, .. } = *point;
    let mut row: Vec<Value> = Vec::with_capacity(COLUMNS.len());
    row.extend([volume.base_m, volume.mu_static, l21_fraction, phi22_rad, arm_ratio].map(Value::Number));
    match &point.state {
        Ok(GraspState { sized, forces }) => {
            let (lengths, sizing) = (&sized.lengths, &sized.sizing);
            row.extend(
                [lengths.l11_m, lengths.l12_m, lengths.l21_m, lengths.l22_m, lengths.t22_m, sized.mass_kg]
                    .map(Value::Number),
            );
            row.extend(
                [sizing.motor_n_m, sizing.spring_n_m, forces.f21_n, forces.f22_n, forces.pfp_n].map(Value::Number),
            );
            row.extend(
                [forces.is_force_positive(), forces.is_palm_force_positive(), sized.form_closed].map(Value::Flag),
            );
            row.push(Value::Missing);
        }
        Err(reason) => {
            row.resize(COLUMNS.len() - 1, Value::Missing);
            row.push(Value::Text(reason.to_string()));
        }
    }
    row
}
