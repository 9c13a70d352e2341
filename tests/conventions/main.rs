//! Tests of the source code itself: dependencies between crates, modules and files, elementary functions, the index of
//! equations, terminology, manifests.

mod equations;
mod glossary;
mod import_cycles;
mod independence;
mod release;
