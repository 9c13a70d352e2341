//! Tests of logs: writing, reading, crashes, replay.
//!
//! All tests are one program to save disk space and link time.

#[path = "../support/mod.rs"]
mod support;

mod crash;
mod decimation;
mod examples;
mod faults_log;
mod faults_process;
mod faults_subjects;
mod order;
mod pictures;
mod provenance;
mod reader;
mod recording;
mod replay_verify;
mod round_trip;
mod run_to;
mod schemas;
