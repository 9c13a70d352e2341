//! Tests of the house itself, read from its sources: which rooms use which, files in circles, elementary functions, where the thesis's equations are.

mod circles;
mod elementary;
mod equations;
mod independence;
