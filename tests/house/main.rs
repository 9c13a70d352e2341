//! Tests of the house itself, read from its sources: which rooms use which, files in circles, where the thesis's equations are.

mod circles;
mod equations;
mod independence;
