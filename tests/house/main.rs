//! Tests of the house itself, read from its sources: which rooms use which, where the thesis's equations are.

mod equations;
mod independence;
