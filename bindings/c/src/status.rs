//! Status codes of all functions, and the sentences that explain them.

use renderer::description::DescriptionError;
use renderer::limits::LimitExceeded;
use renderer::load::LoadError;
use renderer::output::OutputError;
use renderer::render::RenderError;
use renderer::scene::SceneError;
use renderer::world::WorldError;

/// Status that a function returns.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_status {
    /// It is done.
    OVERCOAT_OK = 0,
    /// An argument is null, too short, no UTF-8 or no value of its kind.
    OVERCOAT_INVALID_ARGUMENT = 1,
    /// The object of a number has been removed, never existed, or is of another world.
    OVERCOAT_GONE = 2,
    /// Something else needs it.
    OVERCOAT_IN_USE = 3,
    /// A number is not finite or outside of its range.
    OVERCOAT_OUT_OF_RANGE = 4,
    /// A file cannot be read.
    OVERCOAT_IO = 5,
    /// A file is damaged, or of no format that is known.
    OVERCOAT_MALFORMED = 6,
    /// It would take more than the limits allow.
    OVERCOAT_LIMIT = 7,
    /// overcoat_cancel() was called.
    OVERCOAT_CANCELLED = 8,
    /// Threads flush subnormal numbers to zero or do not round to nearest: pictures would differ from other machines. On x86 and
    /// 64-bit ARM functions set the calling thread's arithmetic right on entry and put it back on return: there it does not happen.
    OVERCOAT_FLOATING_POINT_MODE = 9,
    /// A mistake of this library. What it was called for is in an unknown state; only overcoat_free() is left.
    OVERCOAT_INTERNAL = 10,
}

pub use overcoat_status as Status;

/// Reason of a failed call: status and message.
#[derive(Debug)]
pub struct Failure {
    pub status: Status,
    pub message: String,
}

impl Failure {
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// An argument is no value of its kind.
    pub fn argument(message: impl Into<String>) -> Self {
        Self::new(Status::OVERCOAT_INVALID_ARGUMENT, message)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::new(Status::OVERCOAT_OUT_OF_RANGE, error.to_string())
    }
}

impl From<LimitExceeded> for Failure {
    fn from(error: LimitExceeded) -> Self {
        Self::new(Status::OVERCOAT_LIMIT, error.to_string())
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        let status = match &error {
            LoadError::Io(_) => Status::OVERCOAT_IO,
            LoadError::Limit(_) => Status::OVERCOAT_LIMIT,
            _ => Status::OVERCOAT_MALFORMED,
        };
        Self::new(status, error.to_string())
    }
}

impl From<WorldError> for Failure {
    fn from(error: WorldError) -> Self {
        match error {
            WorldError::Scene(error) => error.into(),
            WorldError::Load(error) => error.into(),
            WorldError::InUse { .. } => Self::new(Status::OVERCOAT_IN_USE, error.to_string()),
            WorldError::TooMany { .. } => Self::new(Status::OVERCOAT_LIMIT, error.to_string()),
            _ => Self::new(Status::OVERCOAT_GONE, error.to_string()),
        }
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        let status = match &error {
            RenderError::Cancelled => Status::OVERCOAT_CANCELLED,
            RenderError::Limit(_) => Status::OVERCOAT_LIMIT,
            RenderError::FloatingPointMode => Status::OVERCOAT_FLOATING_POINT_MODE,
            RenderError::Option { option: "buffer" | "stride" | "region", .. } => {
                Status::OVERCOAT_INVALID_ARGUMENT
            }
            _ => Status::OVERCOAT_OUT_OF_RANGE,
        };
        Self::new(status, error.to_string())
    }
}

impl From<DescriptionError> for Failure {
    fn from(error: DescriptionError) -> Self {
        match error {
            DescriptionError::Limit(error) => error.into(),
            DescriptionError::Load(error) => error.into(),
            DescriptionError::Scene(error) => error.into(),
            other => Self::argument(other.to_string()),
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::argument(error.to_string())
    }
}
