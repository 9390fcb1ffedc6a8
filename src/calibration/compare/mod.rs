//! The model beside the recording: residuals, their weights, noise and slopes.

pub(super) mod blocks;
pub(super) mod comparison;
pub(super) mod noise;
pub(super) mod robust;
pub(super) mod slopes;
pub(super) mod way_back;
