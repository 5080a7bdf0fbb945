//! The referee, against closed forms and against itself, and the models against the referee.

mod bases;
mod lab;
mod report;
mod truth;
