//! What a run is reported as: one document of plain figures, printed for people or as JSON.

mod capture;
mod hold;
mod hold_text;
mod optimize;
mod paper;
mod replay;
mod reproduce;
mod select;
mod simulated;
mod sizing;
mod stability;
mod step_size;
mod sweep;
mod validation;
mod volume;
mod volume_points;

pub use capture::{CaptureReport, PlaceReport as CapturePlaceReport, capture_csv, capture_json, capture_text};
pub use hold::{HoldReport, LimitReport as HoldLimitReport, LoadReport, SizeReport, TriedReport, hold_csv, hold_json};
pub use hold_text::hold_text;
pub use optimize::{
    DesignReport, GainReport, OptimisationReport, is_designs, optimisation_json, optimisation_list, optimisation_paper,
    optimisation_text,
};
pub use paper::{Block, Cell, Figure, Grid, Paper, Section, Text, Tone, paper_html, paper_markdown};
pub use replay::{
    AgainstReport, ApartReport, DifferenceReport, EntryReport, FieldReport, FigureReport, GapReport, Heard, Lost,
    RecoveryReport, ReplayReport, Summary, VerificationReport, WordReport, against_json, against_text, attached,
    recovery_json, recovery_text, replay_json, replay_text, side_by_side,
};
pub use reproduce::{
    Comparison, ReproductionReport, Verdict, comparisons, reproduction_json, reproduction_paper, reproduction_text,
};
pub use select::{
    ClassesReport, CriterionReport, RankedReport, SelectionReport, StatusesReport, VariedReport, is_ranking,
    ranking_table, selection_json, selection_text,
};
pub use simulated::{Broken, Checking, Finished, Making, simulated};
pub use sizing::{SizingReport, sizing_csv, sizing_json, sizing_text};
pub use stability::{stability_csv, stability_json, stability_text};
pub use step_size::{step_size_csv, step_size_json, step_size_text};
pub use sweep::{SweepReport, SweepWork, sweep_json, sweep_list, sweep_text};
pub use validation::{
    AngleDifference, COLUMNS, CheckReport, ContactDifference, DifferencesReport, DiscDifference, DiscDifferences,
    DiscErrors, Errors, FindingReport, ImpactReport, JointDifferences, JointErrors, ModelReport, PairDifference,
    SettingReport, StatisticReport, StatisticsReport, Status, ValidationReport, series, validation_json,
    validation_text,
};
pub use volume::{
    AxesReport, AxisReport, BestReport, Effort, IntersectionReport, ReasonReport, ShareReport, VolumeReport,
    volume_json, volume_text,
};
pub use volume_points::volume_points;

use phalanx_show::report::{check, contacts, csv, discs, document, document_text, grasp, named, tables};

pub use crate::wording::{Quantity, Sheet, condition_name, criterion_key, criterion_name, duration, percent_of};
pub use phalanx_show::report::{
    AnglesReport, BalanceReport, BirglenReport, Came, ClosureReport, ContactPlaceReport, Contacts, CycleReport,
    DirectionReport, DiscReport, DriveReport, Dynamics, Energies, Failure, Final, FinalPostureReport, FingerContacts,
    FingerMotionReport, ForceClosureReport, ForceReport, ForcesReport, GraspReport, GripperClosureReport,
    GripperContactReport, GripperPostureReport, GripperStaticsReport, HandMotionReport, HeldContactReport, HoldsReport,
    LimitReport, MotionReport, MotorReport, MultiplierReport, Named, NecessaryReport, PairReport, PhalanxReport,
    PlaceReport, RateReport, RunCheckReport, RunReport, SpringReport, StaticsReport, TravelReport, Used, WorkReport,
    csv_head, csv_sample, gripper_statics_json, gripper_statics_text, is_samples, json, statics_json, statics_text,
    text,
};
