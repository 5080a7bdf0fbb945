//! The service, as its clients see it: the real program on a port of this machine.

mod bundles;
mod converters;
mod environments;
mod errors;
mod jobs;
mod load;
mod logs;
mod offers;
mod pictures;
mod rights;
mod robust;
mod service;
mod slow;
mod sources;
mod watching;
