//! The service, as its clients see it: the real program on a port of this machine.

mod converters;
mod errors;
mod load;
mod logs;
mod offers;
mod pictures;
mod rights;
mod robust;
mod service;
mod sources;
mod watching;
