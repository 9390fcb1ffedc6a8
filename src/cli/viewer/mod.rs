//! `spinebench view`: robots in three dimensions.

pub(super) mod command;
mod http;
mod live;
mod live_robot;
mod path_scenes;
mod server;

pub(super) use path_scenes::path_scenes;
