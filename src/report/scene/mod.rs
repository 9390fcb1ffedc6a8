//! Robots in three dimensions: a player for pages, the page of the live view, still pictures and
//! moving ones. Scenes come in as data.

mod film;
mod key;
mod live;
mod player;
mod still;

pub use film::{FilmStrip, film};
pub use live::{LiveControl, LiveEffect, LiveParameter, LiveView, live_page};
pub use player::{player, player_page};
